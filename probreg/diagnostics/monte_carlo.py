"""Bias and RMSE over Monte Carlo runs, each with its own standard error."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray


class Measured(NamedTuple):
    """A Monte Carlo estimate and its standard error, arrays of the same shape."""

    value: FloatArray
    standard_error: FloatArray


def bias(estimates: FloatArray, truth: FloatArray | float) -> Measured:
    """Mean error over runs.

    Parameters
    ----------
    estimates : ndarray, shape (runs, ...)
    truth : ndarray, broadcast against one run

    Raises
    ------
    InvalidInputError
        Fewer than two runs, or a non-finite estimate.
    """
    errors = _errors(estimates, truth)
    return Measured(errors.mean(axis=0), errors.std(axis=0, ddof=1) / np.sqrt(len(errors)))


def rmse(estimates: FloatArray, truth: FloatArray | float) -> Measured:
    """Root mean square error over runs; its standard error by the delta method.

    Parameters and errors as for `bias`.
    """
    squares = _errors(estimates, truth) ** 2
    value = np.sqrt(squares.mean(axis=0))
    spread = squares.std(axis=0, ddof=1) / np.sqrt(len(squares))
    return Measured(value, spread / np.maximum(2.0 * value, np.finfo(float).tiny))


def _errors(estimates: FloatArray, truth: FloatArray | float) -> FloatArray:
    errors = np.asarray(estimates, dtype=float) - truth
    if len(errors) < 2:
        raise InvalidInputError(f"{len(errors)} run(s): a Monte Carlo error needs at least two.")
    if not np.isfinite(errors).all():
        bad = int(np.argwhere(~np.isfinite(errors))[0][0])
        raise InvalidInputError(f"run {bad} gave a non-finite estimate; count it, do not drop it.")
    return errors
