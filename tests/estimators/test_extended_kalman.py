"""The extended Kalman filter of bearings, against independent forms."""

from __future__ import annotations

import numpy as np
import pytest

from probreg import BearingProblem, GaussianPrior, UnobservableError
from probreg.errors import InvalidInputError
from probreg.estimators import ExtendedKalman, LeastSquares
from probreg.estimators import _bearing_filter as ekf
from probreg.noise import Contaminated, Gaussian, HardReject, Huber, Igg3, StudentT
from tests.conftest import EMITTER, linear_problem, passive_reports
from tests.estimators.passive_scenes import distant, igg3, scene

LAW = Igg3(1.2, 4.0)


def relative_filter(problem, thresholds=None, gate=None, q=0.0):
    """Equations (1) to (10) in the paper's own state [dx, vx, dy, vy], in plain numpy."""
    own, z, T = problem.own_position, problem.bearing, 1.0
    sine, cosine = np.sin(z[:5]), np.cos(z[:5])
    H5 = np.stack([sine, -cosine], axis=1)
    place = np.linalg.solve(H5.T @ H5, H5.T @ (H5 * own[:5]).sum(axis=1))
    v = (own[1] - own[0]) / T
    x = np.array([place[0] - own[4, 0], -v[0], place[1] - own[4, 1], -v[1]])
    P = np.diag([1e6, 0.0, 1e6, 0.0])
    F = np.kron(np.eye(2), [[1.0, T], [0.0, 1.0]])
    G = np.kron(np.eye(2), [[T**2 / 2], [T]])
    path, passes = [], []
    for k in range(5, len(z)):
        x, P = F @ x, F @ P @ F.T + q**2 * G @ G.T
        r2 = x[0] ** 2 + x[2] ** 2
        H = np.array([-x[2] / r2, 0.0, x[0] / r2, 0.0])
        innovation = np.angle(np.exp(1j * (z[k] - np.arctan2(x[2], x[0]))))
        R, w, count = problem.sigma[k] ** 2, 1.0, 0
        after = x + P @ H / (H @ P @ H + R) * innovation
        if thresholds and (gate is None or innovation**2 / (H @ P @ H + R) > gate):
            while count < 10:
                count += 1
                left = np.angle(np.exp(1j * (z[k] - np.arctan2(after[2], after[0]))))
                w = igg3(left / problem.sigma[k], *thresholds)
                before = after
                after = x + P @ H / (H @ P @ H + R / w) * innovation if w > 0.0 else x
                if np.hypot(after[0] - before[0], after[2] - before[2]) < 0.01:
                    break
        if w > 0.0:
            P = P - np.outer(P @ H, P @ H) / (H @ P @ H + R / w)
        x = after
        path.append([x[0] + own[k, 0], x[2] + own[k, 1]])
        passes.append(count)
    return np.array(path), P[::2, ::2], np.array(passes)


@pytest.mark.parametrize("gate", [None, 7.879])
@pytest.mark.parametrize("thresholds", [None, (1.2, 4.0)])
def test_filter_is_the_papers_in_relative_coordinates(thresholds, gate):
    problem, _ = scene()
    law = Igg3(*thresholds) if thresholds else Gaussian()
    estimate = ExtendedKalman(law, robust_above=gate).estimate(problem)
    path, P, passes = relative_filter(problem, thresholds, gate)
    np.testing.assert_allclose(estimate.path[5:], path, atol=1e-6)
    np.testing.assert_allclose(estimate.covariance, P, rtol=1e-6)
    assert np.isnan(estimate.path[:4]).all()
    np.testing.assert_array_equal(estimate.path[4], estimate.info["start"])
    if thresholds:
        np.testing.assert_array_equal(estimate.info["passes"], passes)
        assert estimate.info["rejected"] == (estimate.weights == 0.0).sum() > 3


def test_a_moving_emitter_is_the_papers_process_noise():
    problem, _ = scene("none")
    estimate = ExtendedKalman(acceleration=1e-2).estimate(problem)
    path, P, _ = relative_filter(problem, q=1e-2)
    np.testing.assert_allclose(estimate.path[5:], path, atol=1e-5)
    np.testing.assert_allclose(estimate.covariance, P, rtol=1e-5)
    fixed = ExtendedKalman().estimate(problem)
    assert (estimate.sd > 1.5 * fixed.sd).all()  # forgetting


def test_without_process_noise_it_is_the_static_two_state_filter():
    problem, _ = scene("none")
    prior = GaussianPrior.from_sd(np.array([800.0, 500.0]), EMITTER + np.array([300.0, -200.0]))
    estimate = ExtendedKalman().estimate(problem, prior)
    x, P = prior.mean.copy(), prior.covariance.copy()
    for z, own, s in zip(problem.bearing, problem.own_position, problem.sigma, strict=True):
        d = x - own
        H = np.array([-d[1], d[0]]) / (d @ d)
        K = P @ H / (H @ P @ H + s**2)
        x, P = x + K * (z - np.arctan2(d[1], d[0])), P - np.outer(K, H @ P)
    np.testing.assert_allclose(estimate.theta, x, atol=1e-6)
    np.testing.assert_allclose(estimate.covariance, P, rtol=1e-8)


def test_with_a_near_start_it_is_batch_least_squares():
    problem, _ = scene("none", sigma_deg=0.01)
    prior = GaussianPrior.from_sd(np.array([1e3, 1e3]), EMITTER + np.array([0.3, -0.2]))
    filtered = ExtendedKalman().estimate(problem, prior)
    batch = LeastSquares().estimate(problem, prior)
    np.testing.assert_allclose(filtered.theta, batch.theta, atol=0.02 * batch.sd.min())
    np.testing.assert_allclose(filtered.covariance, batch.covariance, rtol=1e-3)


def test_the_scale_of_a_law_scales_the_noise():
    problem, _ = scene("none")
    wide = BearingProblem(problem.bearing, problem.own_position, 3.0 * problem.sigma)
    for law in (Gaussian, lambda **k: StudentT(4.0, **k)):
        one = ExtendedKalman(law(scale=3.0)).estimate(problem)
        two = ExtendedKalman(law()).estimate(wide)
        np.testing.assert_allclose(one.path, two.path, rtol=1e-9)
        np.testing.assert_allclose(one.weights[5:], two.weights[5:] / 9.0, rtol=1e-9)


def test_reusing_the_start_loses_no_bearing():
    problem, _ = scene("none")
    paper, reused = (ExtendedKalman(reuse_start=k).estimate(problem) for k in (False, True))
    assert (reused.sd < paper.sd).all()
    assert len(reused.info["passes"]) == len(problem) == len(paper.info["passes"]) + 5


def test_a_bearing_bias_is_estimated_with_the_position():
    reports = passive_reports(3, n=200, bias=0.01, from_north=True)
    problem = BearingProblem.of(reports, sensor_bias=True)
    prior = GaussianPrior.from_sd(np.array([500.0, 500.0, 0.05]), np.array([5.2e3, 9.8e3, 0.0]))
    estimate = ExtendedKalman().estimate(problem, prior)
    batch = LeastSquares().estimate(problem, prior)
    assert (np.abs(estimate.theta - batch.theta) < batch.sd).all()
    np.testing.assert_allclose(estimate.covariance, batch.covariance, rtol=0.2)
    with pytest.raises(InvalidInputError, match="cannot start a bearing bias"):
        ExtendedKalman().estimate(problem)


@pytest.mark.parametrize("law", [Gaussian(), LAW, StudentT(3.0), Huber(1.345), Contaminated()])
def test_compiled_filter_is_the_same_code_in_plain_python(law, monkeypatch):
    problem, _ = scene()
    compiled = ExtendedKalman(law).estimate(problem)
    for name in ("_predict", "_repeat", "_update"):
        monkeypatch.setattr(ekf, name, getattr(ekf, name).py_func)
    plain = ekf.filter_bearings.py_func
    monkeypatch.setattr("probreg.estimators.extended_kalman.filter_bearings", plain)
    slow = ExtendedKalman(law).estimate(problem)
    np.testing.assert_allclose(slow.path, compiled.path, rtol=1e-10)
    np.testing.assert_allclose(slow.weights, compiled.weights, rtol=1e-8, atol=1e-12)


def test_the_robust_filter_stands_where_the_plain_one_falls():
    gaps = {"plain": [], "robust": []}
    for seed in range(20):
        problem, truth = scene(seed=seed)
        for name, law in (("plain", Gaussian()), ("robust", LAW)):
            theta = ExtendedKalman(law).estimate(problem).theta
            gaps[name].append(np.linalg.norm(theta - truth.emitter))
    assert np.mean(gaps["plain"]) > 2.5 * np.mean(gaps["robust"])


# -- settings and bad input --------------------------------------------------------------------


def test_a_start_without_parallax_is_named():
    problem, _ = distant()  # five bearings over 1.2 km, at 180 km
    with pytest.raises(UnobservableError, match="first 5 bearings .* Raise start_bearings"):
        ExtendedKalman().estimate(problem)
    assert ExtendedKalman(start_bearings=60, start_sd=3e4).estimate(problem).converged


def test_nothing_left_to_filter_is_an_error():
    problem, _ = scene("none")
    few = problem.part(slice(5))
    with pytest.raises(UnobservableError, match="none is left to filter"):
        ExtendedKalman().estimate(few)
    assert ExtendedKalman(reuse_start=True).estimate(few).path.shape == (5, 2)


def test_rejecting_everything_is_an_error():
    problem, _ = scene("none")
    far = GaussianPrior.from_sd(np.array([0.01, 0.01]), np.array([-9e3, 2e4]))
    with pytest.raises(UnobservableError, match="rejected all 201"):
        ExtendedKalman(HardReject(1.0)).estimate(problem, far)


def test_settings_are_checked():
    with pytest.raises(InvalidInputError, match="not an array"):
        ExtendedKalman(StudentT(np.array([3.0, 4.0])))
    with pytest.raises(InvalidInputError, match="pass a law"):
        ExtendedKalman(Igg3)
    for bad in (
        {"robust_above": 0.0},
        {"start_sd": -1.0},
        {"acceleration": np.nan},
        {"tolerance": 0.0},
    ):
        with pytest.raises(InvalidInputError, match=next(iter(bad))):
            ExtendedKalman(**bad)
    for bad in ({"start_bearings": 1}, {"max_passes": 0}):
        with pytest.raises(InvalidInputError, match="at least"):
            ExtendedKalman(**bad)
    untimed = BearingProblem.of(passive_reports(1))
    untimed = BearingProblem(untimed.bearing, untimed.own_position, untimed.sigma)
    with pytest.raises(InvalidInputError, match="needs the times"):
        ExtendedKalman(acceleration=1.0).estimate(untimed)


def test_other_problems_are_refused():
    with pytest.raises(InvalidInputError, match="takes a BearingProblem, not a LinearProblem"):
        ExtendedKalman().estimate(linear_problem(1).problem)
