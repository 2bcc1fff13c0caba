"""Residuals of targets that a fit has not seen, before and after correction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from probreg.errors import InvalidInputError, UnobservableError
from probreg.noise import NoiseLaw
from probreg.posterior import WeightedFit
from probreg.problems.linear import LinearProblem
from probreg.registration._fit import some_rows
from probreg.registration._identities import Identified
from probreg.registration._posterior import Fitted
from probreg.typing import FloatArray, IntArray

_STANDARD_ERRORS = 2.0


@dataclass(frozen=True, eq=False)
class HeldOut:
    """How well biases that other targets gave correct the targets held out.

    Attributes
    ----------
    rows : ndarray of int, shape (k,)
        Held-out rows, numbers of the problem.
    targets : int
        Number of targets held out.
    before_m, after_m : ndarray, shape (k,)
        Root mean square residual of each row, metres; NaN for rows with a bearing.
    before_sd, after_sd : ndarray, shape (k,)
        The same in standard deviations that the sensors declare.
    before_log_score, after_log_score : float
        Mean log predictive density of a row.
    gain : ndarray, shape (targets,)
        Log predictive density of each target after correction less before, summed over its rows.
    """

    rows: IntArray
    targets: int
    before_m: FloatArray
    after_m: FloatArray
    before_sd: FloatArray
    after_sd: FloatArray
    before_log_score: float
    after_log_score: float
    gain: FloatArray

    @property
    def verdict(self) -> str:
        """Whether correction makes targets "better", "worse" or "neither", at 2 standard errors.

        The few targets held out make the standard error uncertain, so Student's quantile is taken
        that has the probability of two normal standard errors.
        """
        targets = len(self.gain)
        if targets < 2:
            return "neither"
        bound = float(stats.t.ppf(stats.norm.cdf(_STANDARD_ERRORS), targets - 1))
        bound *= float(self.gain.std(ddof=1) / np.sqrt(targets))
        mean = float(self.gain.mean())
        return "better" if mean > bound else "worse" if mean < -bound else "neither"

    @property
    def medians_m(self) -> tuple[float, float]:
        """Median residual before and after, metres."""
        return float(np.nanmedian(self.before_m)), float(np.nanmedian(self.after_m))


def split_targets(
    target: IntArray, share: float, rng: np.random.Generator
) -> tuple[IntArray, IntArray]:
    """Rows to fit and rows to score: whole targets, about `share` of them, are held out."""
    known = np.unique(target)
    count = min(max(round(share * len(known)), 1), len(known) - 1)
    held = np.isin(target, rng.permutation(known)[:count])
    return np.flatnonzero(~held), np.flatnonzero(held)


def score(
    known: Identified, fitted: Fitted, share: float, rng: np.random.Generator
) -> HeldOut | None:
    """Fit some targets, score the others; None where there is one target only."""
    problem, prior, linear, law = known.problem, known.prior, fitted.linear, fitted.law
    if len(np.unique(problem.plan.target)) < 2:
        return None
    fit, held = split_targets(problem.plan.target, share, rng)
    try:
        theta = WeightedFit(some_rows(linear, fit), law, prior).mode().theta
    except (InvalidInputError, UnobservableError):
        return None
    after = some_rows(linear, held)
    before = problem.take(held).linearise(problem.start)
    zero = np.zeros(len(theta))
    scores = log_score(before, law, zero), log_score(after, law, theta)
    targets, own = np.unique(problem.plan.target[held], return_inverse=True)
    metres = np.where(problem.metric[held], 1.0, np.nan)
    return HeldOut(
        rows=held,
        targets=len(targets),
        before_m=metres * _rms(before.residual(zero), before.size),
        after_m=metres * _rms(after.residual(theta), after.size),
        before_sd=_rms(before.whitened().residual(zero), before.size),
        after_sd=_rms(after.whitened().residual(theta), after.size),
        before_log_score=float(scores[0].mean()),
        after_log_score=float(scores[1].mean()),
        gain=np.bincount(own, scores[1] - scores[0]).astype(float),
    )


def log_score(linear: LinearProblem, law: NoiseLaw, theta: FloatArray) -> FloatArray:
    """Log-density of every row at theta, shape (n,)."""
    rows = linear.whitened()
    return np.asarray(law.log_density(rows.residual(theta), rows.size) - 0.5 * rows.log_det)


def _rms(residual: FloatArray, size: IntArray | None) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("nm,nm->n", residual, residual) / size))
