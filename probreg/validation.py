"""Checks shared by every constructor: shapes, finiteness, positive definiteness."""

from __future__ import annotations

import warnings

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray

LARGE_ANGLE_SIGMA = 0.25  # rad; no tracking sensor is this coarse, but 0.25 deg is common


def finite_array(name: str, value: object, shape: tuple[int | None, ...]) -> FloatArray:
    """Return `value` as a float array after checking its shape and that it is finite.

    Parameters
    ----------
    name : str
        What to call the array in an error.
    value : array_like
        The array.
    shape : tuple of int or None
        Expected shape; None admits any length on that axis.

    Raises
    ------
    InvalidInputError
        Wrong shape, or a NaN or infinity, with its index.
    """
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InvalidInputError(f"{name} must be an array of numbers: {error}") from error
    fits = array.ndim == len(shape) and all(
        want is None or got == want for got, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if s is None else str(s) for s in shape)
        raise InvalidInputError(f"{name} has shape {array.shape}; expected ({wanted}).")
    if not np.isfinite(array).all():
        bad = np.argwhere(~np.isfinite(array))
        where = ", ".join(str(i) for i in bad[0])
        raise InvalidInputError(
            f"{name}[{where}] is {array[tuple(bad[0])]} ({len(bad)} non-finite value(s) in all). "
            "Remove or repair these entries before registration; nothing is dropped silently."
        )
    return array


def positive_definite(name: str, matrices: FloatArray) -> FloatArray:
    """Check that a stack of matrices, shape (n, m, m), is symmetric positive definite.

    Raises
    ------
    InvalidInputError
        Names the first offending matrix and its smallest eigenvalue.
    """
    asymmetry = np.abs(matrices - np.swapaxes(matrices, -1, -2)).max(axis=(-1, -2), initial=0.0)
    size = np.abs(matrices).max(axis=(-1, -2), initial=0.0)
    crooked = np.flatnonzero(asymmetry > 1e-8 * size)
    if crooked.size:
        raise InvalidInputError(
            f"{name}[{crooked[0]}] is not symmetric ({crooked.size} such matrices in all). "
            "Pass a covariance matrix."
        )
    try:
        np.linalg.cholesky(matrices)
    except np.linalg.LinAlgError:
        smallest = np.linalg.eigvalsh(matrices)[..., 0]
        bad = int(np.argmin(smallest / np.maximum(size, np.finfo(float).tiny)))
        raise InvalidInputError(
            f"{name}[{bad}] is not positive definite (smallest eigenvalue {smallest[bad]:.3g}). "
            "Check the sensor accuracies: every one must be above zero, in metres and radians."
        ) from None
    return matrices


def positive_number(name: str, value: float, *, zero: bool = False) -> float:
    """Check one finite number above zero (or not below it, with `zero`)."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InvalidInputError(f"{name} is {value!r}; a number is needed.") from None
    if not np.isfinite(number) or number < 0.0 or (number == 0.0 and not zero):
        bound = "zero or more" if zero else "above zero"
        raise InvalidInputError(f"{name} is {value!r}; it must be finite and {bound}.")
    return number


def whole_number(name: str, value: object) -> None:
    """Check one whole number from 1."""
    if not isinstance(value, int | np.integer) or value < 1:
        raise InvalidInputError(f"{name} is {value!r}; a whole number from 1 is needed.")


def open_share(name: str, value: float) -> float:
    """Check one number strictly between 0 and 1."""
    if not 0.0 < value < 1.0:
        raise InvalidInputError(f"{name} is {value}; it must lie in (0, 1).")
    return value


def sampling_run(num_draws: int, num_chains: int, rng: np.random.Generator) -> None:
    """Check what every sampler is told of a run: how many draws and chains, and a generator."""
    if not isinstance(rng, np.random.Generator):
        raise InvalidInputError("rng must be a numpy.random.Generator: default_rng(seed).")
    whole_number("num_draws", num_draws)
    whole_number("num_chains", num_chains)


def angle_sigma(name: str, value: float) -> float:
    """Check a standard deviation in radians; half a turn is refused, a coarse one questioned."""
    sigma = positive_number(name, value)
    if sigma > np.pi:
        raise InvalidInputError(
            f"{name} is {sigma:.4g} rad, more than half a turn: that looks like degrees. "
            "Pass radians (numpy.deg2rad)."
        )
    if sigma > LARGE_ANGLE_SIGMA:
        warnings.warn(
            f"{name} is {sigma:.4g} rad ({np.rad2deg(sigma):.1f} deg), coarse for a tracking "
            "sensor; were degrees meant?",
            stacklevel=5,
        )
    return sigma


def refuse_degrees(name: str, angles: FloatArray, limit: float) -> None:
    """Raise if more than a quarter of the angles lie beyond what radians can be.

    Single ones may be outliers; a wrong unit shows in most of them.
    """
    row = np.flatnonzero(np.abs(angles) > limit)
    if row.size > 0.25 * len(angles):
        raise InvalidInputError(
            f"{name} is {angles[row[0]]:.4g} in row {row[0]}, and beyond {limit:.3g} in "
            f"{row.size} of {len(angles)} rows: that looks like degrees. Pass radians "
            "(numpy.deg2rad)."
        )
