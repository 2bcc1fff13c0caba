"""The track engine against dense Gaussian algebra, statsmodels and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from statsmodels.tsa.statespace.mlemodel import MLEModel

from probreg.errors import InvalidInputError
from probreg.motion.tracks import (
    ScalarEquations,
    add_bias_uncertainty,
    bias_response,
    draw_tracks,
    eliminate_paths,
    smooth_tracks,
    track_equations,
    track_motion,
    with_times,
)
from tests.motion.dense_tracks import Tracks, dense_posterior, prior_of, random_tracks

SHAPES = [(2, 0), (3, 0), (2, 1), (3, 2), (1, 0)]
DELTA = np.array([3.0, -2.0, 0.5, 1.0])


def rows_of(tracks, k):
    return slice(tracks.equations.target_start[k], tracks.equations.target_start[k + 1])


def relative(found, wanted):
    return np.abs(found - wanted).max(initial=0.0) / max(np.abs(wanted).max(initial=0.0), 1e-9)


def information_errors(tracks, with_process=True):
    found = eliminate_paths(*tracks)
    errors = []
    for k in range(len(tracks.motion.q)):
        dense = dense_posterior(tracks, k, with_process=with_process)
        errors.append(relative(found.precision_by_target[k], dense.J))
        errors.append(relative(found.shift_by_target[k], dense.eta))
        errors.append(relative(found.log_likelihood_by_target[k], dense.ll))
    return max(errors)


@pytest.mark.parametrize("push", [False, True])
@pytest.mark.parametrize(("d", "c"), SHAPES)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_information_is_that_of_dense_algebra(seed, d, c, push):
    narrow = random_tracks(seed, d, c, start_sd=(1e3, 30.0, 40.0), push=push)
    assert information_errors(narrow) < 1e-11
    wide = random_tracks(seed, d, c, start_sd=(1e5, 350.0, 40.0), push=push)
    assert information_errors(wide) < 1e-6


def test_a_filter_that_forgets_the_process_noise_is_found_out():
    tracks = random_tracks(1, start_sd=(1e3, 30.0, 40.0))
    assert information_errors(tracks, with_process=False) > 1e-2
    still = tracks._replace(motion=tracks.motion._replace(q=np.zeros(len(tracks.motion.q))))
    assert information_errors(still) < 1e-10


@pytest.mark.parametrize(("d", "c"), SHAPES)
@pytest.mark.parametrize("seed", [4, 5])
def test_smoothed_states_are_those_of_dense_algebra(seed, d, c):
    tracks = random_tracks(seed, d, c, push=True)
    equations, motion, p, weights = tracks
    found = smooth_tracks(equations, motion, weights, DELTA, covariance=True, spread=True)
    response = bias_response(equations, motion, p, weights)
    for k in range(len(motion.q)):
        dense, rows = dense_posterior(tracks, k, DELTA), rows_of(tracks, k)
        own = np.einsum("iaib->iab", dense.covariance)
        assert relative(found.mean[rows], dense.mean) < 1e-9
        # 3000^2 is what cancels
        assert np.abs(found.covariance[rows] - own).max() < 1e-8 * 3e3**2
        assert relative(response[rows], dense.response) < 1e-9
    sigma = np.diag([1.0, 2.0, 3.0, 4.0]) + 0.5
    total = add_bias_uncertainty(found.covariance, equations, motion, sigma, weights)
    wanted = found.covariance + response @ sigma @ np.swapaxes(response, 1, 2)
    np.testing.assert_allclose(total, wanted, rtol=1e-10, atol=1e-10)


def counted(tracks, k):
    """Which equations are of target k and there, (E,)."""
    equations = tracks.equations
    there = tracks.weights[equations.report] > 1e-6
    return there & (equations.target[equations.report] == k)


def in_many_digits(tracks, k):
    """Mean and covariance of the states of target k, in fifty digits."""
    mp = pytest.importorskip("mpmath")
    equations, motion, _, weights = tracks
    size, d = motion.start_mean.shape[1], equations.dim
    mean, prior = prior_of(tracks, k)
    seen = np.flatnonzero(counted(tracks, k))
    H = np.zeros((len(seen), len(mean)))
    at = (equations.report[seen] - equations.target_start[k]) * size
    for a in range(d):
        H[np.arange(len(seen)), at + a] = equations.h[seen, a]
    noise = equations.variance[seen] / weights[equations.report[seen]]
    with mp.workdps(50):
        H, P = mp.matrix(H.tolist()), mp.matrix(prior.tolist())
        gain = P * H.T * mp.inverse(H * P * H.T + mp.diag(noise.tolist()))
        m = mp.matrix(mean.tolist())
        mean = m + gain * (mp.matrix(equations.y[seen].tolist()) - H * m)
        covariance = P - gain * H * P
        n = len(m) // size
        return (
            np.array(mean.tolist(), dtype=float).reshape(n, size),
            np.array(covariance.tolist(), dtype=float).reshape(n, size, n, size),
        )


@pytest.mark.parametrize("seed", [2, 3])
def test_a_wide_start_costs_few_digits(seed):
    """Against fifty digits: a dense computation in sixteen is further off than the smoother."""
    tracks = random_tracks(seed, 3, start_sd=(1e5, 350.0, 0.0))
    equations, motion, _, weights = tracks
    found = smooth_tracks(equations, motion, weights, covariance=True)
    for k in range(len(motion.q)):
        if not counted(tracks, k).any():
            continue
        mean, full = in_many_digits(tracks, k)
        rows, own = rows_of(tracks, k), np.einsum("iaib->iab", full)
        sd = np.sqrt(np.einsum("iaa->ia", own))
        assert np.abs((found.mean[rows] - mean) / sd).max() < 1e-7
        scale = sd[:, :, None] * sd[:, None, :]
        assert np.abs((found.covariance[rows] - own) / scale).max() < 5e-3


def test_residuals_and_their_spread_follow_from_the_states():
    equations, motion, _, weights = random_tracks(6, 3, 1)
    found = smooth_tracks(equations, motion, weights, DELTA, covariance=True, spread=True)
    own = [0, 1, 2, 6]
    for i in range(len(equations.time)):
        rows = np.arange(equations.report_start[i], equations.report_start[i + 1])
        h = equations.h[rows]
        y = equations.minus_biases(DELTA)[rows]
        np.testing.assert_allclose(found.residual[rows], y - h @ found.mean[i][own], atol=1e-9)
        A = h @ found.covariance[i][np.ix_(own, own)] @ h.T
        # 3000^2 is what cancels
        np.testing.assert_allclose(found.spread[rows, : len(rows)], A, atol=1e-12 * 3e3**2)


def test_states_between_reports_are_those_of_dense_algebra():
    tracks = random_tracks(7, 2, 1, push=True)
    equations, motion, p, weights = tracks
    # after the first report, between, at one, and beyond the last
    start, end = equations.target_start[:-1], equations.target_start[1:] - 1
    target = np.repeat(np.arange(len(motion.q)), 4)
    first, last = equations.time[start][target], equations.time[end][target]
    share = np.tile([0.0, 0.31, 0.77, 1.4], len(motion.q))
    finer, where = with_times(equations, target, first + share * (last - first + 1.0))
    more = np.zeros(len(finer.time))
    more[np.setdiff1d(np.arange(len(more)), where)] = weights
    np.testing.assert_allclose(finer.time[where], first + share * (last - first + 1.0))
    both = Tracks(finer, motion, p, more)
    found = smooth_tracks(finer, motion, more, covariance=True)
    for k in range(len(motion.q)):
        dense, rows = dense_posterior(both, k), rows_of(both, k)
        assert relative(found.mean[rows], dense.mean) < 1e-9
    # and the states at the reports are what they were
    before = smooth_tracks(equations, motion, weights)
    kept = np.setdiff1d(np.arange(len(more)), where)
    np.testing.assert_allclose(found.mean[kept], before.mean, rtol=1e-9, atol=1e-7)


def test_times_before_the_first_report_are_refused():
    equations, *_ = random_tracks(7)
    with pytest.raises(InvalidInputError, match="before the first report"):
        with_times(equations, np.array([0]), np.array([0.0]))
    with pytest.raises(InvalidInputError, match="from 0 to 3"):
        with_times(equations, np.array([4]), np.array([500.0]))


def test_draws_have_the_mean_and_covariance_of_dense_algebra():
    tracks = random_tracks(8, 2, 1, start_sd=(300.0, 20.0, 40.0), targets=2)
    equations, motion, _, weights = tracks
    rng = np.random.default_rng(0)
    draws = np.array(
        [draw_tracks(equations, motion, rng, weights, DELTA).mean for _ in range(4000)]
    )
    scores, ratios = [], []
    for k in range(len(motion.q)):
        dense, rows = dense_posterior(tracks, k, DELTA), rows_of(tracks, k)
        size = dense.mean.size
        cloud = (draws[:, rows] - dense.mean).reshape(len(draws), size)
        root = np.linalg.cholesky(dense.covariance.reshape(size, size) + 1e-9 * np.eye(size))
        z = np.linalg.solve(root, cloud.T).T
        # coincident reports leave directions without any spread: their z says nothing
        z = z[:, np.diag(root) > 1e-3]
        scores.append(z.mean(axis=0) * np.sqrt(len(z)))
        products = (z.T @ z / len(z) - np.eye(z.shape[1])) * np.sqrt(len(z))
        ratios.append((products / np.sqrt(1.0 + np.eye(z.shape[1]))).ravel())
    scores = np.concatenate([*scores, *ratios])
    # one false alarm in a thousand seeds, by Bonferroni
    assert np.abs(scores).max() < stats.norm.isf(0.5e-3 / len(scores))


def test_residuals_of_a_draw_are_against_the_draw():
    equations, motion, _, weights = random_tracks(9, 3, 0)
    found = draw_tracks(equations, motion, np.random.default_rng(1), weights, DELTA)
    fitted = np.einsum("ed,ed->e", equations.h, found.mean[equations.report, :3])
    np.testing.assert_allclose(found.residual, equations.minus_biases(DELTA) - fitted, atol=1e-8)


def test_slopes_are_finite_differences_of_the_log_likelihood():
    equations, motion, p, weights = random_tracks(10, 3, 1)
    found = eliminate_paths(equations, motion, p, weights)

    def log_likelihood(delta):
        moved = equations._replace(y=equations.minus_biases(delta))
        return eliminate_paths(moved, motion, p, weights).log_likelihood

    step = 1.0
    unit = step * np.eye(p)
    slope = [(log_likelihood(u) - log_likelihood(-u)) / (2.0 * step) for u in unit]
    bend = [
        (log_likelihood(u) - 2.0 * log_likelihood(0.0 * u) + log_likelihood(-u)) / step**2
        for u in unit
    ]
    # the log-likelihood is quadratic: differences are exact but for rounding
    np.testing.assert_allclose(found.shift, slope, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(np.diag(found.precision), -np.array(bend), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(found.at(DELTA), log_likelihood(DELTA), rtol=1e-11)


def test_the_order_of_targets_does_not_matter():
    tracks = random_tracks(11, 2, 1, push=True)
    equations, motion, p, weights = tracks
    order = np.array([2, 0, 3, 1])
    starts = equations.target_start
    reports = np.concatenate([np.arange(starts[k], starts[k + 1]) for k in order])
    owns = equations.report_start
    rows = np.concatenate([np.arange(owns[i], owns[i + 1]) for i in reports])
    moved = track_equations(
        np.concatenate([[0], np.cumsum(np.diff(starts)[order])]),
        np.concatenate([[0], np.cumsum(np.diff(owns)[reports])]),
        equations.time[reports],
        ScalarEquations(
            equations.y[rows],
            equations.h[rows, :2],
            equations.variance[rows],
            equations.h[rows, 2:],
            equations.column[rows],
            equations.response[rows],
        ),
        equations.push[reports],
    )
    shuffled = track_motion(
        moved, motion.q[order], motion.start_mean[order], np.sqrt(motion.start_variance[order])
    )
    one = eliminate_paths(equations, motion, p, weights)
    two = eliminate_paths(moved, shuffled, p, weights[reports])
    np.testing.assert_allclose(two.shift_by_target, one.shift_by_target[order], rtol=1e-9)
    np.testing.assert_allclose(two.precision, one.precision, rtol=1e-9)
    smooth = smooth_tracks(equations, motion, weights)
    again = smooth_tracks(moved, shuffled, weights[reports])
    np.testing.assert_allclose(again.mean, smooth.mean[reports], rtol=1e-8, atol=1e-8)


class OneTrack(MLEModel):
    """Positions of one target at equal intervals, for statsmodels."""

    def __init__(self, positions, interval, q, variance, mean, start_variance):
        super().__init__(positions, k_states=4)
        dt, eye = interval, np.eye(2)
        self["design"] = np.hstack([eye, 0.0 * eye])
        self["transition"] = np.kron([[1.0, dt], [0.0, 1.0]], eye)
        self["selection"] = np.eye(4)
        self["state_cov"] = q * np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], eye)
        self["obs_cov"] = np.diag(variance)
        self.ssm.initialize_known(mean, np.diag(start_variance))


def test_one_track_agrees_with_statsmodels():
    rng = np.random.default_rng(12)
    n, interval, q = 40, 4.0, 2.0
    positions = np.cumsum(rng.normal(size=(n, 2)), axis=0) * 100.0
    missing = rng.random(n) < 0.2
    mean, sd = np.array([10.0, 20.0, 3.0, -4.0]), np.array([500.0, 500.0, 30.0, 30.0])
    variance = np.array([50.0**2, 70.0**2])
    given = positions.copy()
    given[missing] = np.nan
    model = OneTrack(given, interval, q, variance, mean, sd**2)
    theirs = model.smooth([])
    equations = track_equations(
        np.array([0, n]),
        2 * np.arange(n + 1),
        interval * np.arange(n),
        ScalarEquations(positions.ravel(), np.tile(np.eye(2), (n, 1)), np.tile(variance, n)),
    )
    motion = track_motion(equations, q, mean, sd)
    weights = (~missing).astype(float)
    ours = eliminate_paths(equations, motion, 0, weights)
    np.testing.assert_allclose(ours.log_likelihood, theirs.llf, rtol=1e-9)
    smooth = smooth_tracks(equations, motion, weights, covariance=True)
    np.testing.assert_allclose(smooth.mean, theirs.smoothed_state.T, rtol=1e-7, atol=1e-7)
    cov = np.moveaxis(theirs.smoothed_state_cov, -1, 0)
    np.testing.assert_allclose(smooth.covariance, cov, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": [1.0, 0.0, 2.0]}, "time goes back at report 1"),
        ({"variance": [1.0, 0.0, 1.0]}, "variance"),
        ({"report_start": np.array([0, 1, 2, 4])}, "from 0 to 3"),
        ({"y": [0.0, np.nan, 0.0]}, "non-finite"),
        ({"h": np.zeros((2, 2))}, "shape"),
        ({"column": np.full((3, 1), -1), "response": np.ones((3, 1))}, "one index from zero"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(change, message):
    scalar = {"y": np.zeros(3), "h": np.ones((3, 2)), "variance": np.ones(3)}
    layout = {"target_start": np.array([0, 3]), "report_start": np.arange(4), "time": np.arange(3)}
    scalar.update({k: v for k, v in change.items() if k in ScalarEquations._fields})
    layout.update({k: v for k, v in change.items() if k in layout})
    with pytest.raises(InvalidInputError, match=message):
        track_equations(**layout, scalar=ScalarEquations(**scalar))


def test_weights_columns_and_starts_that_do_not_fit_are_refused():
    equations, motion, p, weights = random_tracks(13)
    with pytest.raises(InvalidInputError, match="a column is 3; there are 2"):
        eliminate_paths(equations, motion, 2, weights)
    with pytest.raises(InvalidInputError, match="one a report"):
        eliminate_paths(equations, motion, p, weights[:-1])
    with pytest.raises(InvalidInputError, match="weight 0 is -1"):
        eliminate_paths(equations, motion, p, np.full(len(weights), -1.0))
    with pytest.raises(InvalidInputError, match="4 targets of 4 states"):
        track_motion(equations, np.ones(3), 0.0, 1.0)
    endless = motion._replace(start_variance=np.full_like(motion.start_variance, np.inf))
    with pytest.raises(InvalidInputError, match="not finite"):
        eliminate_paths(equations, endless, p)
