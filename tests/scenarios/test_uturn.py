"""The U-turn scene, and the exact filter and smoother on it against independent numbers."""

from __future__ import annotations

import numpy as np
import pytest

from probreg import GaussianPrior, ReportProblem
from probreg.errors import InvalidInputError
from probreg.motion.dynamics import Constant, RandomWalk
from probreg.problems import as_trajectory
from probreg.scenarios.uturn import UturnScene, fly, simulate


def test_the_track_is_continuous_and_turns_back():
    scene = UturnScene()
    time = np.linspace(0.0, 180.0, 18_001)
    positions = fly(scene, time)
    speed = np.linalg.norm(np.diff(positions, axis=0), axis=1) / np.diff(time)
    np.testing.assert_allclose(speed, 300.0, rtol=1e-4)
    np.testing.assert_allclose(positions[0], [-20e3, 0.0])
    assert positions[:, 1].min() == pytest.approx(-9000.0)
    assert positions[-1, 0] == pytest.approx(-300.0 * (180.0 - 200.0 / 3.0 - 15.0 * np.pi))


def test_the_bias_starts_from_zero_before_the_first_scan():
    # 2000 runs of two axes: variances at 5 standard errors, false-alarm rate 1e-5
    scene = UturnScene(scans=20)
    bias = np.array([simulate(scene, np.random.default_rng(k))[1].bias for k in range(2000)])
    for scan in (0, 19):
        variance = (bias[:, scan] ** 2).mean()
        expected = 1000.0 * (scan + 1)
        assert abs(variance / expected - 1.0) < 5.0 * np.sqrt(2.0 / 4000)


def track(form, drifting, seed):
    """Exact trajectory of the sensor's bias, the reference's held at zero."""
    data, truth = simulate(UturnScene(form, drifting), np.random.default_rng(seed))
    problem = ReportProblem(data)
    linear = problem.linearise(np.zeros(4))
    fixed = np.full(2, 1e-12)
    if drifting:
        # zero before the first scan, so one step of drift at it
        prior = GaussianPrior(np.zeros(4), np.diag([1000.0, 1000.0, *fixed]))
        model = as_trajectory(linear, RandomWalk(np.array([1e3, 1e3, 0.0, 0.0])), prior)
    else:
        prior = GaussianPrior(np.zeros(4), np.diag([300.0**2, 300.0**2, *fixed]))
        model = as_trajectory(linear, Constant(), prior)
    return model, truth


# RMSE of the bias over runs and times: Kalman filter and RTS smoother, 400 runs of an
# independent implementation
EXPECTED = {
    ("reference", True): (55.9, 44.1),
    ("pair", True): (68.9, 52.8),
    ("reference", False): (15.7, 6.6),
    ("pair", False): (22.2, 9.8),
}


@pytest.mark.parametrize("key", EXPECTED, ids=str)
def test_exact_filter_and_smoother_have_the_independent_errors(key):
    # 8 comparisons at 4 standard errors of the difference: false-alarm rate 5e-4
    squares = []
    for seed in range(100):
        model, truth = track(*key, seed)
        filtered = model.filter()
        means = filtered.mean[:, :2], model.smooth(filtered).mean[:, :2]
        squares.append([((m - truth.bias) ** 2).sum(axis=1).mean() for m in means])
    mean, spread = np.mean(squares, axis=0), np.std(squares, axis=0)
    rmse = np.sqrt(mean)
    # ours from 100 runs, theirs from 400
    error = spread / 2.0 / rmse * np.sqrt(1.0 / 100 + 1.0 / 400)
    assert (np.abs(rmse - EXPECTED[key]) < 4.0 * error + 0.05).all()


def test_steady_state_is_that_of_the_riccati_equation():
    for form, expected in (("reference", (39.52, 31.15)), ("pair", (48.71, None))):
        model, _ = track(form, True, 0)
        filtered = model.filter()
        assert np.sqrt(filtered.covariance[-1, 0, 0]) == pytest.approx(expected[0], abs=0.01)
        if expected[1]:
            smoothed = model.smooth(filtered)
            assert np.sqrt(smoothed.covariance[90, 0, 0]) == pytest.approx(expected[1], abs=0.01)


def test_intervals_of_the_exact_filter_cover():
    # 40 runs x 180 scans x 2 axes; runs are the independent unit: 5 standard errors
    shares = []
    for seed in range(40):
        model, truth = track("reference", True, seed)
        filtered = model.filter()
        sd = np.sqrt(np.einsum("taa->ta", filtered.covariance))[:, :2]
        shares.append(np.mean(np.abs(filtered.mean[:, :2] - truth.bias) < 1.6449 * sd))
    assert abs(np.mean(shares) - 0.9) < 5.0 * np.std(shares) / np.sqrt(40)


def test_settings_are_checked():
    with pytest.raises(InvalidInputError, match="form is 'alone'"):
        UturnScene("alone")
    with pytest.raises(InvalidInputError, match="scans"):
        UturnScene(scans=0)
