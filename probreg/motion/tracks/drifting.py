"""What targets' reports say about biases that drift, the paths integrated out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks._drifting import Totals, Window, drifting_information
from probreg.motion.tracks._equations import TrackEquations, TrackMotion
from probreg.typing import BoolArray, FloatArray

MOST_COEFFICIENTS = 2_000
MEMORY_S = 60.0  # after which a track knows next to nothing of a bias
FEWEST_LIVE = 3


@dataclass(frozen=True, eq=False)
class DriftInformation:
    """Log marginal likelihood of all coefficients, ll + eta . delta - delta' J delta / 2.

    Attributes
    ----------
    precision : ndarray, shape (P, P)
        J, of all targets.
    shift_by_target : ndarray, shape (K, P)
    log_likelihood_by_target : ndarray, shape (K,)
        At delta = 0.
    """

    precision: FloatArray
    shift_by_target: FloatArray
    log_likelihood_by_target: FloatArray

    @cached_property
    def shift(self) -> FloatArray:
        """Eta, shape (P,)."""
        total: FloatArray = self.shift_by_target.sum(axis=0)
        return total

    @property
    def log_likelihood(self) -> float:
        """At delta = 0."""
        return float(self.log_likelihood_by_target.sum())

    @property
    def telling(self) -> BoolArray:
        """Which targets (K,) say something of the biases."""
        return np.asarray((self.shift_by_target != 0.0).any(axis=1))


def eliminate_drifting(
    equations: TrackEquations,
    motion: TrackMotion,
    columns: tuple[int, int],
    knots: FloatArray,
    weights: FloatArray | None = None,
) -> DriftInformation:
    """Integrate every target's path out, by a filter that carries live bias columns along.

    A track forgets a column within about a minute: of each drifting bias it carries the knots of
    the last minute, three at least. What it still answers to an older knot it then answers to
    the next one, so that biases that do not move lose nothing.

    Parameters
    ----------
    equations : TrackEquations
        Columns of constant biases first, then those of all drifting ones knot by knot.
    motion : TrackMotion
    columns : (int, int)
        How many biases are constant, how many drift.
    knots : ndarray, shape (T,)
        Their times, increasing.
    weights : ndarray, shape (n,) or (E,), optional
        Precision of each report, or each equation, over the nominal one.

    Raises
    ------
    InvalidInputError
        More than 2000 coefficients, a column beyond them, variances that double precision cannot
        hold together.
    """
    P, K = _size(equations, columns, len(knots)), len(motion.q)
    totals = Totals(np.empty((P, P)), np.empty((K, P)), np.empty(K))
    window = Window(*columns, len(knots), live_knots(knots))
    precision = equations.precision(weights)
    drifting_information(equations.shape, equations, motion, precision, window, totals)
    lost = np.flatnonzero(~np.isfinite(totals.ll))
    if lost.size:
        raise InvalidInputError(
            f"the information of target {lost[0]} ({lost.size} in all) is not finite: its start is "
            "too wide, or time steps are too long, for reports so accurate."
        )
    return DriftInformation(totals.J, totals.eta, totals.ll)


def _size(equations: TrackEquations, columns: tuple[int, int], T: int) -> int:
    """P, if it is neither too large nor too small."""
    static, drifting = columns
    P = static + drifting * T
    if P > MOST_COEFFICIENTS:
        raise InvalidInputError(
            f"{drifting} drifting biases at {T} knots are {P} coefficients, of at most "
            f"{MOST_COEFFICIENTS}: let fewer biases drift, or place knots further apart."
        )
    if equations.column.size and equations.column.max() >= P:
        raise InvalidInputError(f"a column is {equations.column.max()}; there are {P}.")
    return P


def live_knots(knots: FloatArray) -> int:
    """Knots that a track carries along: those of any minute, and the two that it is between."""
    within = np.searchsorted(knots, knots + MEMORY_S, side="right") - np.arange(len(knots))
    return min(max(int(within.max(initial=0)) + 1, FEWEST_LIVE), len(knots))
