"""A simulated recording as files, for trying things out: `reports.csv` and `sensors.toml`.

The truth is written to a separate file, `truth.json`.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import new_table, setup_file
from probreg.recordings.files import replacing
from probreg.scenarios.traffic import TrafficScene, simulate

SCENE = TrafficScene(reports=6_000, wrong_share=0.05, outlier_share=0.02)


def demonstration(
    folder: str | Path, rng: np.random.Generator, scene: TrafficScene = SCENE
) -> tuple[Path, Path, Path]:
    """Simulate a scene and write it.

    Parameters
    ----------
    folder : str or Path
        Created if missing.
    rng : numpy.random.Generator
    scene : TrafficScene, optional
        Default three radars with drawn biases, a few wrong identities and outliers.

    Returns
    -------
    reports, sensors, truth : Path
        The truth holds the biases by name (SI units), and the rows of the reports, from 0,
        that are under a wrong identity and that are outliers.

    Raises
    ------
    InvalidInputError
        A folder that cannot be written, a scene whose sensors have no kind in such files.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInputError(f"{folder} cannot be made: {error.strerror}.") from None
    recording, setup, truth = simulate(scene, rng)
    reports, sensors, known = (
        folder / name for name in ("reports.csv", "sensors.toml", "truth.json")
    )
    setup_file.write(sensors, setup)
    new_table.create(reports, recording, setup)
    content = {
        "bias": truth.bias,
        "wrong_rows": np.flatnonzero(truth.wrong).tolist(),
        "outlier_rows": np.flatnonzero(truth.outlier).tolist(),
    }
    with replacing(known) as part:
        part.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return reports, sensors, known
