"""Judges of samplers: means and variances in Monte-Carlo standard errors, after an ESS gate."""

from __future__ import annotations

import numpy as np
from scipy import stats

from probreg import arviz_adapter


def z_scores(draws, mean, variance, least=200.0, error=0.0, variance_error=0.0):
    """Scores (2 d,) of means and of mean squares about the reference mean.

    Each is judged by the effective sample size of its own series; fewer effective draws than
    `least` are an error of the test, not a verdict on the sampler.
    """
    theta = draws.theta
    found = []
    errors = np.broadcast_to(error, len(mean)), np.broadcast_to(variance_error, len(mean))
    for k in range(theta.shape[-1]):
        away = theta[..., k] - mean[k]
        for x, target, own in ((away, 0.0, errors[0][k]), (away**2, variance[k], errors[1][k])):
            ess = arviz_adapter.ess(x, "mean")
            assert ess >= least, f"only {ess:.0f} effective draws"
            found.append((x.mean() - target) / np.hypot(x.std() / np.sqrt(ess), own))
    return np.array(found)


def limit(scores, false_alarm):
    """Bonferroni limit of |z| for a family-wise false-alarm rate."""
    return stats.norm.isf(0.5 * false_alarm / np.size(scores))
