"""What filter and smoother return, and what a trajectory must pass."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.numerics import kalman
from probreg.typing import BoolArray, FloatArray
from probreg.validation import finite_array, positive_definite


class Filtered(NamedTuple):
    """What a Kalman filter knows before and after each scan.

    Attributes
    ----------
    predicted, mean : ndarray, shape (T, d)
    predicted_covariance, covariance : ndarray, shape (T, d, d)
    log_likelihood : float
        Log marginal likelihood of all rows.
    """

    predicted: FloatArray
    predicted_covariance: FloatArray
    mean: FloatArray
    covariance: FloatArray
    log_likelihood: float


class Smoothed(NamedTuple):
    """What all scans together say about each.

    Attributes
    ----------
    mean : ndarray, shape (T, d)
    covariance : ndarray, shape (T, d, d)
    cross : ndarray, shape (T - 1, d, d)
        Covariance of scan t with scan t + 1.
    """

    mean: FloatArray
    covariance: FloatArray
    cross: FloatArray


class Backward(NamedTuple):
    """A Gaussian posterior of a path as an affine map of standard normal numbers.

    Attributes
    ----------
    mean : ndarray, shape (T, d)
    gains : ndarray, shape (T - 1, d, d)
    roots : ndarray, shape (T, d, d)
    """

    mean: FloatArray
    gains: FloatArray
    roots: FloatArray

    def paths(self, z: FloatArray) -> FloatArray:
        """Paths (k, T, d) of standard normal numbers (k, T, d)."""
        delta = np.empty_like(z)
        kalman.spread(self.gains, self.roots, z, delta)
        return self.mean + delta

    def pull_back(self, slope: FloatArray) -> FloatArray:
        """Derivatives by z (k, T, d) from derivatives by paths (k, T, d)."""
        out = np.empty_like(slope)
        kalman.gather(self.gains, self.roots, np.ascontiguousarray(slope), out)
        return out


def steps(name: str, value: FloatArray, T: int, d: int) -> FloatArray:
    """Steps (T - 1, d, d), from one for all or one each."""
    try:
        full = np.broadcast_to(value, (T - 1, d, d))
    except ValueError:
        raise InvalidInputError(
            f"{name} has shape {np.shape(value)}; ({T - 1}, {d}, {d}) or ({d}, {d}) is needed."
        ) from None
    return finite_array(name, full, (T - 1, d, d))


def reported(given: FloatArray | None, T: int, m: int) -> BoolArray:
    """Which components were reported, (T, m): all of them if nothing is said."""
    present = np.ones((T, m), dtype=bool) if given is None else np.asarray(given)
    if present.shape != (T, m):
        raise InvalidInputError(f"present has shape {present.shape}; ({T}, {m}) is needed.")
    if not np.isin(present, (0, 1)).all():
        raise InvalidInputError("present must say true or false (1 or 0) of every component.")
    return present.astype(bool)


def scale_matrices(given: FloatArray, present: BoolArray) -> FloatArray:
    """R of the components present; the others uncorrelated, of unit variance."""
    T, m = present.shape
    R = np.asarray(given, dtype=float)
    k = R.shape[1] if R.ndim == 4 else 1
    width = m // k if k else 0
    if R.shape not in ((T, m, m), (T, k, width, width)) or k * width != m:
        raise InvalidInputError(
            f"R has shape {R.shape}; ({T}, {m}, {m}), or blocks ({T}, rows, width, width) with "
            f"{m} components in all, is needed."
        )
    own = present.reshape(T, k, width) if R.ndim == 4 else present
    both = own[..., :, None] & own[..., None, :]
    R = np.where(both, R, 0.0) + np.eye(width) * ~own[..., None]
    R = finite_array("R", R, R.shape)
    positive_definite("R", R.reshape(-1, width, width))
    return R


def in_order(given: FloatArray, T: int) -> FloatArray:
    """Times (T,) that do not go back.

    Raises
    ------
    InvalidInputError
        They do, or are not finite.
    """
    time = finite_array("time", given, (T,))
    late = np.flatnonzero(np.diff(time) < 0.0)
    if late.size:
        raise InvalidInputError(
            f"time goes back after scan {late[0]} ({time[late[0]]:g} to "
            f"{time[late[0] + 1]:g} s); sort the scans first."
        )
    return time
