"""What targets' reports say about the biases, the paths integrated out exactly."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks._equations import TrackEquations, TrackMotion
from probreg.motion.tracks._filter import information
from probreg.typing import FloatArray


@dataclass(frozen=True, eq=False)
class BiasInformation:
    """Log marginal likelihood of the biases, ll + eta . delta - delta' J delta / 2, by target.

    Attributes
    ----------
    precision_by_target : ndarray, shape (K, p, p)
    shift_by_target : ndarray, shape (K, p)
    log_likelihood_by_target : ndarray, shape (K,)
        At delta = 0.
    """

    precision_by_target: FloatArray
    shift_by_target: FloatArray
    log_likelihood_by_target: FloatArray

    @cached_property
    def precision(self) -> FloatArray:
        """J, shape (p, p)."""
        total: FloatArray = self.precision_by_target.sum(axis=0)
        return total

    @cached_property
    def shift(self) -> FloatArray:
        """Eta, shape (p,)."""
        total: FloatArray = self.shift_by_target.sum(axis=0)
        return total

    @property
    def log_likelihood(self) -> float:
        """At delta = 0."""
        return float(self.log_likelihood_by_target.sum())

    def at(self, delta: FloatArray) -> float:
        """Log marginal likelihood at delta (p,)."""
        step = np.asarray(delta, dtype=float)
        return float(self.log_likelihood + step @ (self.shift - 0.5 * self.precision @ step))


def eliminate_paths(
    equations: TrackEquations,
    motion: TrackMotion,
    num_biases: int,
    weights: FloatArray | None = None,
) -> BiasInformation:
    """Integrate every target's path out, by a filter that carries the bias columns along.

    Parameters
    ----------
    equations : TrackEquations
    motion : TrackMotion
    num_biases : int
        p; columns of the equations count from 0 to p - 1.
    weights : ndarray, shape (n,) or (E,), optional
        Precision of each report, or each equation, over the nominal one.

    Returns
    -------
    BiasInformation

    Raises
    ------
    InvalidInputError
        A column beyond the biases; variances that double precision cannot hold together.

    References
    ----------
    de Jong, "The diffuse Kalman filter", Annals of Statistics 19 (1991).
    """
    if equations.column.size and equations.column.max() >= num_biases:
        raise InvalidInputError(f"a column is {equations.column.max()}; there are {num_biases}.")
    K = len(motion.q)
    J, eta, ll = np.empty((K, num_biases, num_biases)), np.empty((K, num_biases)), np.empty(K)
    information(equations.shape, equations, motion, equations.precision(weights), J, eta, ll)
    lost = np.flatnonzero(~np.isfinite(ll))
    if lost.size:
        raise InvalidInputError(
            f"the information of target {lost[0]} ({lost.size} in all) is not finite: its start is "
            "too wide, or time steps are too long, for reports so accurate. Check times and "
            "standard deviations."
        )
    return BiasInformation(J, eta, ll)
