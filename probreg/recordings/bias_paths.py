"""Biases that are known over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray
from probreg.validation import finite_array


@dataclass(frozen=True, eq=False)
class BiasPaths:
    """All biases of a setup at times: linear between them, and held beyond the first and last.

    Parameters
    ----------
    time : ndarray, shape (T,)
        Stamps of reports, seconds, increasing.
    values : ndarray, shape (T, p)
        SI units, in the order of `bias_model`.

    Raises
    ------
    InvalidInputError
        Shapes that do not fit, no time, times that do not increase.
    """

    time: FloatArray
    values: FloatArray

    def __post_init__(self) -> None:
        time = finite_array("time of bias paths", self.time, (None,))
        if not len(time) or (np.diff(time) <= 0.0).any():
            raise InvalidInputError("times of bias paths must increase; one is needed at least.")
        values = finite_array("values of bias paths", self.values, (len(time), None))
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "values", values)

    def at(self, stamp: FloatArray) -> FloatArray:
        """Biases (n, p) at stamps (n,)."""
        columns = [np.interp(stamp, self.time, own) for own in self.values.T]
        return np.stack(columns, axis=1) if columns else np.zeros((len(stamp), 0))


Biases = FloatArray | BiasPaths
