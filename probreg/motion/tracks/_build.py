"""Arrays checked and put together as equations and motion of targets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks._equations import TrackEquations, TrackMotion
from probreg.typing import FloatArray, IntArray
from probreg.validation import finite_array


class ScalarEquations(NamedTuple):
    """Equations as they come, report by report.

    Attributes
    ----------
    y, variance : ndarray, shape (E,)
    h : ndarray, shape (E, d)
        Sensitivity to the position.
    constants : ndarray, shape (E, c), optional
        Sensitivity to the constants of the target.
    column, response : ndarray, shape (E, S), optional
        Indices of biases and the sensitivities to them.
    """

    y: FloatArray
    h: FloatArray
    variance: FloatArray
    constants: FloatArray | None = None
    column: IntArray | None = None
    response: FloatArray | None = None


def track_equations(
    target_start: IntArray,
    report_start: IntArray,
    time: FloatArray,
    scalar: ScalarEquations,
    push: FloatArray | None = None,
) -> TrackEquations:
    """Check arrays and put them together; see `TrackEquations`.

    Raises
    ------
    InvalidInputError
        Shapes that do not fit, numbers that are not finite, time that goes back within a
        target, a variance that is not above zero, a negative column.
    """
    first = _offsets("target_start", target_start, np.size(time))
    own = _offsets("report_start", report_start, np.size(scalar.y))
    n, E = int(first[-1]), int(own[-1])
    h = np.ascontiguousarray(finite_array("h", scalar.h, (E, None)))
    d = h.shape[1]
    extra = np.zeros((E, 0)) if scalar.constants is None else np.asarray(scalar.constants)
    response = np.zeros((E, 0)) if scalar.response is None else scalar.response
    column = np.zeros((E, 0), dtype=int) if scalar.column is None else np.asarray(scalar.column)
    response = finite_array("response", response, (E, None))
    if column.shape != response.shape or column.dtype.kind not in "iu" or (column < 0).any():
        raise InvalidInputError(
            f"column has shape {column.shape}, response {response.shape}; one index from zero "
            "for each response is needed."
        )
    found = TrackEquations(
        first,
        own,
        finite_array("time", time, (n,)),
        finite_array("y", scalar.y, (E,)),
        h if extra.shape == (E, 0) else np.hstack([h, finite_array("constants", extra, (E, None))]),
        finite_array("variance", scalar.variance, (E,)),
        np.ascontiguousarray(column, dtype=np.int64),
        np.ascontiguousarray(response),
        np.zeros((0, d))
        if push is None
        else np.ascontiguousarray(finite_array("push", push, (n, d))),
    )
    _check(found)
    return found


def _check(found: TrackEquations) -> None:
    """Time goes forward within a target, and noise has a variance."""
    back = np.flatnonzero((np.diff(found.time) < 0.0) & (np.diff(found.target) == 0))
    if back.size:
        raise InvalidInputError(
            f"time goes back at report {back[0] + 1}: sort the reports by target and time."
        )
    bad = np.flatnonzero(found.variance <= 0.0)
    if bad.size:
        raise InvalidInputError(f"variance[{bad[0]}] is {found.variance[bad[0]]}, not above zero.")


def track_motion(
    equations: TrackEquations,
    q: float | FloatArray,
    start_mean: FloatArray,
    start_sd: FloatArray,
) -> TrackMotion:
    """Check and spread over the targets: q, means and standard deviations of the start.

    Raises
    ------
    InvalidInputError
        Shapes that do not fit, a negative density, a standard deviation that is not above zero.
    """
    K = len(equations.target_start) - 1
    size = 2 * equations.dim + equations.num_constants
    try:
        density = np.broadcast_to(np.asarray(q, dtype=float), (K,))
        mean = np.broadcast_to(np.asarray(start_mean, dtype=float), (K, size))
        sd = np.broadcast_to(np.asarray(start_sd, dtype=float), (K, size))
    except ValueError as error:
        raise InvalidInputError(f"{K} targets of {size} states each are needed: {error}") from None
    density = finite_array("q", density, (K,))
    if (density < 0.0).any() or not (finite_array("start_sd", sd, (K, size)) > 0.0).all():
        raise InvalidInputError("q must be zero or more, every start_sd above zero.")
    mean = finite_array("start_mean", mean, (K, size))
    return TrackMotion(*(np.ascontiguousarray(a) for a in (density, mean, sd**2)))


def _offsets(name: str, value: object, total: int) -> IntArray:
    offsets = np.asarray(value)
    whole = offsets.ndim == 1 and offsets.size > 0 and offsets.dtype.kind in "iu"
    if not whole or offsets[0] != 0 or (np.diff(offsets) < 0).any() or offsets[-1] != total:
        raise InvalidInputError(
            f"{name} must be whole numbers that do not decrease, from 0 to {total}."
        )
    return np.ascontiguousarray(offsets, dtype=np.int64)
