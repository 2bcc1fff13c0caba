"""The file `biases.json` of a registration, of which another recording is corrected."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray


def read_biases(path: str | Path, names: Sequence[str]) -> FloatArray:
    """Means of the biases from a `biases.json`, SI units, in the order of names.

    Raises
    ------
    InvalidInputError
        No such file, or the biases of other sensors.
    """
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
        means = {row["name"]: float(row["mean"]) for row in content["biases"]}
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError):
        raise InvalidInputError(f"{path} is no biases.json of `probreg register`.") from None
    if set(means) != set(names):
        raise InvalidInputError(
            f"{path} has the biases {sorted(means)}, the setup {sorted(names)}; they must be the "
            "same. Give the sensors.toml of that registration."
        )
    return np.array([means[name] for name in names])
