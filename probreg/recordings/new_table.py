"""A table of reports that no file gave: simulated ones, or those read from another format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from probreg.errors import InvalidInputError
from probreg.geometry import azimuth_from_north
from probreg.recordings._columns import COMPONENTS, OWN
from probreg.recordings._files import replacing
from probreg.recordings._formats import format_of
from probreg.recordings._recording import Recording
from probreg.recordings._rows import COMPASS, factor
from probreg.recordings._setup import Setup


def create(path: str | Path, recording: Recording, setup: Setup) -> None:
    """Write a recording as a new table that `table.read` reads.

    Parameters
    ----------
    path : str or Path
        Ends with .csv or .parquet.
    recording : Recording
    setup : Setup
        Without an origin on the earth: azimuths of the table count from the frame's north.

    Raises
    ------
    InvalidInputError
        A setup with an origin, an ending not known, a folder that cannot be written.
    """
    path = Path(path)
    format_of(path)
    if setup.origin is not None:
        raise InvalidInputError("a new table counts azimuths from the frame's north; no origin.")
    names = np.array([sensor.name for sensor in recording.sensors])
    columns = {"time_s": recording.time, "sensor": names[recording.sensor]}
    for k, sensor in enumerate(recording.sensors):
        rows = np.flatnonzero(recording.sensor == k)
        for j, name in enumerate(sensor.bias_names):
            cells = columns.setdefault(COMPONENTS[name], np.full(len(recording), np.nan))
            values = recording.values[rows, j] / factor(COMPONENTS[name])
            north = name in COMPASS and sensor.from_north  # type: ignore[attr-defined]
            cells[rows] = np.mod(values, 360.0) if north else values
    if recording.labels:
        columns["target"] = np.array([*recording.labels, ""])[recording.target]
    if recording.own_position is not None:
        columns.update(zip(OWN, recording.own_position.T, strict=False))
    if recording.heading is not None:
        columns["heading_deg"] = np.rad2deg(azimuth_from_north(recording.heading))
    frame = pd.DataFrame(columns)
    with replacing(path) as part:
        if path.suffix.lower() == ".csv":
            frame.to_csv(part, index=False)
        else:
            frame.to_parquet(part, index=False)
