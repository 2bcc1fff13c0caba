"""Correction scored on whole targets that it was not fitted to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from probreg.posterior.tracks import (
    Prediction,
    TrackFit,
    predict,
    some_targets_say,
    telling_targets,
)
from probreg.typing import FloatArray, IntArray

_STANDARD_ERRORS = 2.0
MOST_REPORTS = 20_000  # held out, that are enough to judge by


@dataclass(frozen=True, eq=False)
class HeldOut:
    """How well biases that other targets gave correct the targets held out.

    Attributes
    ----------
    rows : ndarray of int, shape (k,)
        Held-out reports, numbers of the problem.
    targets : int
        Number of targets held out.
    before_m, after_m : ndarray, shape (k,)
        Root mean square residual of each report against the path by all others, metres.
    before_sd, after_sd : ndarray, shape (k,)
        The same in standard deviations of that residual.
    before_log_score, after_log_score : float
        Mean log density of a report given all others of its target.
    gain : ndarray, shape (targets,)
        Log density of each target after correction less before, summed over its reports.
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


def score(fit: TrackFit, share: float, rng: np.random.Generator) -> HeldOut | None:
    """Biases of some targets, scored on the others; None where there is one target only."""
    known = telling_targets(fit)
    if len(known) < 2:
        return None
    count = min(max(round(share * len(known)), 1), len(known) - 1)
    held = rng.permutation(known)[:count]
    theta = some_targets_say(fit, np.setdiff1d(known, held))
    enough = np.cumsum(fit.model.reports.counts[held]) <= MOST_REPORTS
    enough[0] = True
    held = np.sort(held[enough])
    after = predict(fit, theta, held)
    before = predict(fit, fit.model.prior_coefficients, held)
    sides = [_metres(one) for one in (before, after)]
    scores = [_by_report(one, one.judged.log_density) for one in (before, after)]
    own = fit.model.reports.target[after.rows]
    _, own = np.unique(own, return_inverse=True)
    return HeldOut(
        rows=after.rows,
        targets=len(held),
        before_m=sides[0][0],
        after_m=sides[1][0],
        before_sd=sides[0][1],
        after_sd=sides[1][1],
        before_log_score=float(scores[0].mean()),
        after_log_score=float(scores[1].mean()),
        gain=np.bincount(own, scores[1] - scores[0]).astype(float),
    )


def _by_report(one: Prediction, values: FloatArray) -> FloatArray:
    """Values in the order of the tangent, in that of the reports."""
    return values[one.tangent.order]


def _metres(one: Prediction) -> tuple[FloatArray, FloatArray]:
    """Root mean square residual of each report, in metres and in its standard deviations."""
    left, report = one.left_out, one.tangent.equations.report
    n = len(one.rows)
    count = np.maximum(np.bincount(report, minlength=n), 1)
    sides = (left.residual**2, left.residual**2 / left.variance)
    metres, sds = (np.sqrt(np.bincount(report, side, n) / count) for side in sides)
    return _by_report(one, metres), _by_report(one, sds)
