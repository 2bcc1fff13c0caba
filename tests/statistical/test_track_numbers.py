"""Tracks of simulated traffic over twenty recordings: at the bound of an oracle.

The oracle knows identities, which reports are outliers, and where to linearise.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from sklearn.metrics import roc_auc_score

from probreg.posterior.tracks import fit_tracks
from tests.posterior.traffic_tracks import draw, model_of, not_as_said, oracle

SEEDS = 20
pytestmark = pytest.mark.slow


def recording_of(seed, wrong, outliers):
    recording, setup, truth = draw(seed, wrong_share=wrong, outlier_share=outliers)
    model, names = model_of(recording, setup, wrong_share=0.05 if wrong else 0.0)
    fit = fit_tracks(model)
    known = oracle(model, truth, fit.point.density)
    bound = np.sqrt(np.diag(known.covariance))
    error = (fit.theta - np.array([truth.bias[name] for name in names])) / bound
    named_wrong = recording.target != truth.target
    bad = not_as_said(recording, fit)
    return fit.sd / bound, error, bad, named_wrong, truth.outlier


@pytest.mark.parametrize(("wrong", "outliers"), [(0.0, 0.0), (0.0, 0.05), (0.2, 0.05)])
def test_biases_are_at_the_bound(wrong, outliers):
    runs = [recording_of(seed, wrong, outliers) for seed in range(SEEDS)]
    ratio, error = (np.array([run[k] for run in runs]) for k in (0, 1))
    assert ratio.mean() < 1.02
    assert ratio.mean() > 0.97
    # a mean square of 20 times 6 errors, a false alarm in a thousand
    low, high = stats.chi2(error.size).ppf([5e-4, 1.0 - 5e-4]) / error.size
    assert low < np.mean(error**2) < high
    held = int((np.abs(error / ratio) < stats.norm.isf(0.05)).sum())
    interval = stats.binomtest(held, error.size).proportion_ci(0.999)
    assert interval.low < 0.9 < interval.high
    if outliers:
        bad, named_wrong, outlier = (np.concatenate([run[k] for run in runs]) for k in (2, 3, 4))
        good = ~named_wrong & ~outlier
        assert (bad[good] > 0.5).mean() < 0.002
        # among good reports an outlier of ten times the noise hides: 100 / 101 at most
        assert roc_auc_score(outlier[~named_wrong], bad[~named_wrong]) > 0.985
        # the probability of one half and its like mean what they say
        for low, high in ((0.1, 0.3), (0.3, 0.7), (0.7, 0.9)):
            some = (bad > low) & (bad < high)
            assert abs(bad[some].mean() - (~good)[some].mean()) < 3.3 * 0.5 / np.sqrt(some.sum())
    if wrong:
        assert roc_auc_score(~good, bad) > 0.995
