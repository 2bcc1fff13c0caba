"""Do intervals cover? Exact binomial limits, and intervals from draws or covariances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import bdtr, betaincinv, ndtri

from probreg.errors import InvalidInputError
from probreg.typing import BoolArray, FloatArray
from probreg.validation import open_share


@dataclass(frozen=True)
class Coverage:
    """How often intervals contained the truth.

    Attributes
    ----------
    held, trials : int
    nominal : float
        Probability that the intervals claim.
    """

    held: int
    trials: int
    nominal: float

    @property
    def value(self) -> float:
        """Share of intervals that contained the truth."""
        return self.held / self.trials

    def limits(self, false_alarm: float = 0.05) -> tuple[float, float]:
        """Limits of the coverage of calibrated intervals at this false-alarm rate."""
        return binomial_limits(self.trials, self.nominal, false_alarm)

    def honest(self, false_alarm: float = 0.05) -> bool:
        """Whether the share lies within the exact binomial limits."""
        low, high = self.limits(false_alarm)
        return low <= self.value <= high

    def confidence(self, level: float = 0.95) -> tuple[float, float]:
        """Clopper-Pearson interval of the true coverage."""
        tail, k, n = 0.5 * (1.0 - level), self.held, self.trials
        low = 0.0 if k == 0 else float(betaincinv(k, n - k + 1, tail))
        high = 1.0 if k == n else float(betaincinv(k + 1, n - k, 1.0 - tail))
        return low, high


def coverage(intervals: FloatArray, truth: FloatArray, nominal: float) -> list[Coverage]:
    """Coverage of each unknown over replicates.

    Parameters
    ----------
    intervals : ndarray, shape (replicates, d, 2)
    truth : ndarray, shape (replicates, d) or (d,)
    nominal : float

    Raises
    ------
    InvalidInputError
        Not finite, or shapes that do not fit.
    """
    intervals = np.asarray(intervals, dtype=float)
    if intervals.ndim != 3 or intervals.shape[2] != 2 or not np.isfinite(intervals).all():
        raise InvalidInputError(
            f"intervals have shape {intervals.shape}; (replicates, d, 2), all finite, is needed."
        )
    open_share("nominal", nominal)
    truth = np.asarray(truth, dtype=float)
    if truth.shape not in (intervals.shape[:2], intervals.shape[1:2]):
        raise InvalidInputError(
            f"truth has shape {truth.shape}; {intervals.shape[1:2]} or {intervals.shape[:2]} is "
            "needed."
        )
    if not np.isfinite(truth).all():
        raise InvalidInputError("a truth is not finite: it can be in no interval.")
    truth = np.broadcast_to(truth, intervals.shape[:2])
    held: BoolArray = (intervals[..., 0] <= truth) & (truth <= intervals[..., 1])
    return [Coverage(int(column.sum()), len(column), nominal) for column in held.T]


def normal_interval(estimate: FloatArray, covariance: FloatArray, probability: float) -> FloatArray:
    """Intervals (..., d, 2) that estimates and claimed covariances give, as if Gaussian."""
    share = open_share("probability", probability)
    sd = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    half = float(ndtri(0.5 + 0.5 * share)) * sd
    return np.stack([estimate - half, estimate + half], axis=-1)


def binomial_limits(trials: int, probability: float, false_alarm: float) -> tuple[float, float]:
    """Limits of a binomial proportion, which lies outside with at most this probability.

    Exact: at most half the false-alarm rate in each tail.

    Raises
    ------
    InvalidInputError
        No trial, or a probability out of range.
    """
    if trials < 1 or not (0.0 < probability < 1.0 and 0.0 < false_alarm < 1.0):
        raise InvalidInputError(
            f"binomial_limits({trials}, {probability}, {false_alarm}): at least one trial and "
            "probabilities in (0, 1) are needed."
        )
    below = bdtr(np.arange(trials + 1, dtype=float), trials, probability)  # P(count <= k)
    low = int(np.searchsorted(below, 0.5 * false_alarm, side="right"))
    high = int(np.searchsorted(below, 1.0 - 0.5 * false_alarm, side="left"))
    return low / trials, high / trials
