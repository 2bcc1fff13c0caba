"""Leave-one-out densities against the dense prediction of each report from all others."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from probreg.motion.tracks import LEAST_WEIGHT, smooth_tracks
from probreg.posterior.tracks.cavity import ReportMixtures, judge_reports, room_for
from tests.motion.dense_tracks import dense_posterior, random_tracks

MIXTURES = {"share": np.array([0.9, 0.1]), "variance": np.array([1.0, 25.0])}
WRONG, ELSEWHERE = 0.05, 1e-6


def judged(tracks):
    equations, motion, _, weights = tracks
    smoothed = smooth_tracks(equations, motion, weights, spread=True)
    n = len(equations.time)
    mixtures = ReportMixtures(
        np.zeros(n, dtype=int),
        np.append(np.log((1.0 - WRONG) * MIXTURES["share"]), -np.inf)[None],
        np.append(MIXTURES["variance"], 1.0)[None],
        np.full(n, np.log(WRONG * ELSEWHERE)),
    )
    out = room_for(n, 3)
    there = np.where(weights < LEAST_WEIGHT, 0.0, weights)
    judge_reports(equations, (smoothed.residual, smoothed.spread), there, mixtures, 5e3, out)
    return out


def left_out(tracks, i):
    """Mean and covariance of report i's residual given all others of its target, dense."""
    equations, motion, _, weights = tracks
    k = int(equations.target[i])
    without = weights.copy()
    without[i] = 0.0
    dense = dense_posterior(tracks._replace(weights=without), k)
    at = i - equations.target_start[k]
    rows = slice(equations.report_start[i], equations.report_start[i + 1])
    d = equations.dim
    own = np.r_[0:d, 2 * d : motion.start_mean.shape[1]]
    h = equations.h[rows]
    residual = equations.y[rows] - h @ dense.mean[at][own]
    covariance = h @ dense.covariance[at][:, at][np.ix_(own, own)] @ h.T
    return residual, covariance, np.diag(equations.variance[rows])


@pytest.mark.parametrize(("d", "c", "seed"), [(2, 0, 1), (3, 1, 2), (2, 1, 3)])
def test_reports_are_judged_by_the_density_that_the_others_give(d, c, seed):
    tracks = random_tracks(seed, d, c, start_sd=(1e3, 30.0, 40.0))
    found = judged(tracks)
    for i in range(len(tracks.equations.time)):
        a, A, R = left_out(tracks, i)
        parts = []
        for j in range(2):
            C = A + MIXTURES["variance"][j] * R
            density = stats.multivariate_normal(np.zeros(len(a)), C).logpdf(a) if len(a) else 0.0
            parts.append(np.log((1.0 - WRONG) * MIXTURES["share"][j]) + density)
            if len(a):
                # noise given the residual: mean K a, covariance S - K S
                S = MIXTURES["variance"][j] * R
                K = S @ np.linalg.inv(C)
                second = K @ np.outer(a, a) @ K.T + S - K @ S
                wanted = np.trace(np.linalg.inv(R) @ second)
                np.testing.assert_allclose(found.square[i, j], wanted, rtol=1e-6, atol=1e-6)
        parts.append(np.log(WRONG * ELSEWHERE))
        total = np.logaddexp.reduce(parts)
        np.testing.assert_allclose(found.log_density[i], total, rtol=1e-8, atol=1e-8)
        wanted = np.exp(parts - total)
        np.testing.assert_allclose(found.probability[i], [*wanted[:2], 0.0], atol=1e-8)
        np.testing.assert_allclose(found.wrong[i], wanted[2], atol=1e-8)
        np.testing.assert_allclose(found.weight[i], wanted[0] + wanted[1] / 25.0, atol=1e-8)
        assert found.placed[i] == (len(a) > 0 and np.diag(A).max() < 5e3**2)


def test_a_lone_report_is_placed_by_no_other():
    tracks = random_tracks(4, start_sd=(1e5, 350.0, 0.0), targets=12)
    equations = tracks.equations
    lone = np.flatnonzero(np.diff(equations.target_start) == 1)
    reports = equations.target_start[lone]
    reports = reports[np.diff(equations.report_start)[reports] > 0]
    assert reports.size
    assert not judged(tracks).placed[reports].any()
