"""Scalar equations of targets' reports, in order of target and time, and how targets move."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray, IntArray

LEAST_WEIGHT = 1e-6  # a report of less weight is not there: 1e-300 is no zero to a filter


# dimensions and constants as the lengths of two tuples: compiled code knows them beforehand
Shape = tuple[tuple[int, ...], tuple[int, ...]]


class TrackEquations(NamedTuple):
    """Reports as equations y = h . (position, constants) + s . biases + N(0, variance / w).

    Reports are sorted by target and time; a report has any number of equations, none too.

    Attributes
    ----------
    target_start : ndarray of int, shape (K + 1,)
        Where the reports of each target begin; its last entry is their number n.
    report_start : ndarray of int, shape (n + 1,)
        Where the equations of each report begin; its last entry is their number E.
    time : ndarray, shape (n,)
        Seconds, not decreasing within a target.
    y : ndarray, shape (E,)
        What is observed, relative to the origin of the target's state.
    h : ndarray, shape (E, d + c)
        Sensitivity to position and to the constants of the target.
    variance : ndarray, shape (E,)
        Of the noise at weight one.
    column : ndarray of int, shape (E, S)
        Which biases enter; places that are not needed hold any index and a response of zero.
    response : ndarray, shape (E, S)
        The sensitivity s to them.
    push : ndarray, shape (n, d) or (0, d)
        Known acceleration from the report before to each report, such as the fall of level
        flight in a rigid frame.
    """

    target_start: IntArray
    report_start: IntArray
    time: FloatArray
    y: FloatArray
    h: FloatArray
    variance: FloatArray
    column: IntArray
    response: FloatArray
    push: FloatArray

    @property
    def dim(self) -> int:
        """Dimensions of the position."""
        return self.push.shape[1]

    @property
    def num_constants(self) -> int:
        """Constants of a target."""
        return self.h.shape[1] - self.push.shape[1]

    @property
    def shape(self) -> Shape:
        """Dimensions and constants, for compiled code."""
        return (0,) * self.dim, (0,) * self.num_constants

    @property
    def target(self) -> IntArray:
        """Number of the target of each report, shape (n,)."""
        return np.repeat(np.arange(len(self.target_start) - 1), np.diff(self.target_start))

    @property
    def report(self) -> IntArray:
        """Number of the report of each equation, shape (E,)."""
        return np.repeat(np.arange(len(self.time)), np.diff(self.report_start))

    def precision(self, weights: FloatArray | None = None) -> FloatArray:
        """Precision of each equation under weights (n,) of reports or (E,) of equations.

        Zero where the weight is below `LEAST_WEIGHT`: such an equation is not there.
        """
        if weights is None:
            return 1.0 / self.variance
        w = np.asarray(weights, dtype=float)
        if w.shape not in (self.time.shape, self.y.shape):
            raise InvalidInputError(
                f"weights have shape {w.shape}; one a report ({len(self.time)},) or one an "
                f"equation ({len(self.y)},) is needed."
            )
        bad = np.flatnonzero(~((w >= 0.0) & (w < np.inf)))
        if bad.size:
            raise InvalidInputError(f"weight {bad[0]} is {w[bad[0]]}; it must be zero or more.")
        there = np.where(w < LEAST_WEIGHT, 0.0, w)
        if w.shape == self.time.shape:
            there = np.repeat(there, np.diff(self.report_start))
        return np.asarray(there / self.variance)

    def of_targets(self, targets: IntArray) -> TrackEquations:
        """The equations of some targets, in the order given."""
        reports = spans(self.target_start, targets)
        rows = spans(self.report_start, reports)
        return TrackEquations(
            np.concatenate([[0], np.cumsum(np.diff(self.target_start)[targets])]),
            np.concatenate([[0], np.cumsum(np.diff(self.report_start)[reports])]),
            self.time[reports],
            self.y[rows],
            self.h[rows],
            self.variance[rows],
            self.column[rows],
            self.response[rows],
            self.push[reports] if len(self.push) else self.push,
        )

    def minus_biases(self, delta: FloatArray) -> FloatArray:
        """What is observed less the biases' part, y - s . delta, shape (E,)."""
        if not self.column.size:
            return self.y
        return self.y - np.einsum("es,es->e", self.response, np.asarray(delta)[self.column])


class TrackMotion(NamedTuple):
    """How targets move: white acceleration, from a wide start at the time of the first report.

    Attributes
    ----------
    q : ndarray, shape (K,)
        Density of the acceleration of each target, (m/s^2)^2 / Hz.
    start_mean, start_variance : ndarray, shape (K, 2 d + c)
        Of position, velocity and constants, which are independent at the start; covariances
        (K, 2 d + c, 2 d + c) where they are not.
    """

    q: FloatArray
    start_mean: FloatArray
    start_variance: FloatArray


def spans(start: IntArray, which: IntArray) -> IntArray:
    """Numbers of the members of groups `which`, whose first members are `start`."""
    count = np.diff(start)[which]
    ends = np.cumsum(count)
    total = int(ends[-1]) if len(ends) else 0
    return np.arange(total) - np.repeat(ends - count, count) + np.repeat(start[which], count)
