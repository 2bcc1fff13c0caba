"""Target and bias together: against the contrast, dense algebra, and its gauge."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import GaussianPrior
from probreg.errors import InvalidInputError, UnobservableError
from probreg.motion.dynamics import Constant, NearConstantVelocity, RandomWalk, Together
from probreg.motion.target_state import Target, follow_target
from probreg.noise import Gaussian, StudentT
from probreg.scenarios.uturn import UturnScene, simulate
from tests.motion.test_trajectory import dense

BIAS = GaussianPrior.from_sd(np.full(2, 200.0))
WALK = RandomWalk(np.full(2, 1000.0))


def scene(scans=12, **changed):
    data, truth = simulate(UturnScene("pair", scans=scans, **changed), np.random.default_rng(2))
    return data, truth, Target(np.array([-19_700.0, 0.0]), np.array([300.0, 0.0]))


def test_the_state_is_the_dense_conditional():
    data, _, target = scene()
    model = follow_target(data, target, {"sensor": (WALK, BIAS)})
    assert model.names[-2:] == ("sensor.x", "sensor.y")
    assert model.width == 2
    mean, covariance, log_density = dense(model)
    smoothed = model.smooth()
    np.testing.assert_allclose(smoothed.mean, mean, rtol=1e-7, atol=1e-4)
    assert model.filter().log_likelihood == pytest.approx(log_density, rel=1e-9)
    own = np.diag(covariance).reshape(len(model), -1)
    np.testing.assert_allclose(np.diagonal(smoothed.covariance, axis1=1, axis2=2), own, rtol=1e-5)


def test_a_target_that_may_be_anywhere_gives_the_contrast():
    # with velocity and acceleration unknown every scan stands alone: b ~ N(z1 - z2, 2 R)
    data, _, target = scene(scans=3)
    free = dataclasses.replace(target, position_sd=1e6, velocity_sd=1e6, acceleration_sd=1e6)
    wide = GaussianPrior.from_sd(np.full(2, 1e4))
    model = follow_target(data, free, {"sensor": (RandomWalk(np.full(2, 1e8)), wide)})
    found = model.smooth()
    np.testing.assert_allclose(found.mean[:, 4:], data.values[0] - data.values[1], rtol=2e-3)
    np.testing.assert_allclose(found.covariance[:, 4, 4], 8000.0, rtol=2e-3)


def test_motion_tells_more_than_contrasts():
    data, _, target = scene(scans=60)
    constant = follow_target(data, target, {"sensor": (WALK, BIAS)})
    contrast = dataclasses.replace(target, acceleration_sd=1e5)
    without = follow_target(data, contrast, {"sensor": (WALK, BIAS)})
    assert constant.smooth().covariance[30, 4, 4] < 0.9 * without.smooth().covariance[30, 4, 4]


def test_steps_of_the_target():
    F, Q = NearConstantVelocity(3.0).step(4, 2.0)
    np.testing.assert_allclose(F @ [1.0, 2.0, 10.0, 20.0], [21.0, 42.0, 10.0, 20.0])
    np.testing.assert_allclose(Q[0::2, 0::2], 9.0 * np.array([[4.0, 4.0], [4.0, 4.0]]))
    F, Q = Together(((NearConstantVelocity(3.0), 2), (WALK, 2))).step(4, 1.0)
    np.testing.assert_allclose(Q[2:, 2:], 1000.0 * np.eye(2))
    assert not Q[:2, 2:].any()
    with pytest.raises(InvalidInputError, match="no pairs"):
        NearConstantVelocity(1.0).step(3, 1.0)
    with pytest.raises(InvalidInputError, match="has 5"):
        Together(((Constant(), 2),)).step(5, 1.0)


def test_a_gauge_is_explained():
    data, _, target = scene()
    with pytest.raises(UnobservableError, match="only differences are determined"):
        follow_target(data, target, dict.fromkeys(("sensor", "reference"), (WALK, BIAS)))
    with pytest.raises(InvalidInputError, match="the sensors are"):
        follow_target(data, target, {"other": (WALK, BIAS)})
    with pytest.raises(InvalidInputError, match="needs the times"):
        follow_target(dataclasses.replace(data, time=None), target, {"sensor": (WALK, BIAS)})


@pytest.mark.parametrize("law", [Gaussian(), StudentT(6.0)], ids=repr)
def test_simulated_paths_have_the_moments_of_the_model(law):
    # 4000 draws; scores against closed-form moments, family-wise 1e-4 of 12
    data, _, target = scene(scans=4)
    model = follow_target(data, target, {"sensor": (WALK, BIAS)})
    rng = np.random.default_rng(5)
    runs = [model.simulate(law, rng) for _ in range(4000)]
    last = np.array([path[-1] for path, _ in runs])
    left = np.array([m.y[-1] - m.H[-1] @ p[-1] for p, m in runs])
    spread = 1000.0**2 + 9 * 50.0**2 + 25.0 * (2.5**2 + 1.5**2 + 0.5**2)
    for values, mean, variance in (
        (last[:, 0], target.position[0] + 900.0, spread),
        (last[:, 4], 0.0, 200.0**2 + 3000.0),
        (left[:, 0], 0.0, 4000.0 * float(law.covariance_factor(2))),
    ):
        away = values - mean
        for sample, expected in ((away, 0.0), (away**2, variance)):
            z = (sample.mean() - expected) / (sample.std() / np.sqrt(len(sample)))
            assert abs(z) < 4.4
