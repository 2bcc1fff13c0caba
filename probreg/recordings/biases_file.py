"""The file `biases.json` of a registration, of which another recording is corrected."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings.bias_paths import Biases, BiasPaths


def read_biases(path: str | Path, names: Sequence[str]) -> Biases:
    """Means of the biases from a `biases.json`, SI units, in the order of names.

    Mean paths where some drift.

    Raises
    ------
    InvalidInputError
        No such file, or the biases of other sensors.
    """
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
        means = {row["name"]: float(row["mean"]) for row in content["biases"]}
        paths = {row["name"]: (row["time"], row["mean"]) for row in content.get("paths", [])}
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError):
        raise InvalidInputError(f"{path} is no biases.json of `probreg register`.") from None
    if set(means) != set(names):
        raise InvalidInputError(
            f"{path} has the biases {sorted(means)}, the setup {sorted(names)}; they must be the "
            "same. Give the sensors.toml of that registration."
        )
    constant = np.array([means[name] for name in names])
    if not paths:
        return constant
    time = np.asarray(next(iter(paths.values()))[0], dtype=float)
    values = np.tile(constant, (len(time), 1))
    for name, (_, mean) in paths.items():
        values[:, list(names).index(name)] = mean
    return BiasPaths(time, values)
