"""Every estimator found in probreg.estimators, and recursion and IRLS under every law."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import probreg.estimators
import probreg.noise
from probreg import (
    BearingProblem,
    BearingReports,
    BearingSensor,
    GaussianPrior,
    LinearProblem,
    Posterior,
    Radar2D,
    ReportProblem,
    UnobservableError,
)
from probreg.discovery import public_classes
from probreg.errors import InvalidInputError
from probreg.estimators import Irls, Lms, Recursive
from tests.conftest import (
    EMITTER,
    PAIR_BIAS,
    linear_problem,
    passive_reports,
    polar_reports,
    radar_pair,
)

LAWS = [cls() for cls in public_classes(probreg.noise).values()]
ESTIMATORS = [cls() for cls in public_classes(probreg.estimators).values()]
VARIANTS = [Irls(law) for law in LAWS] + [Recursive(law) for law in LAWS] + [Lms("equation")]
# those that take one kind of problem only say which
ANY = [e for e in ESTIMATORS if getattr(e, "problem_type", None) is None]
ALL = ANY + VARIANTS
PASSIVE = [e for e in ESTIMATORS if getattr(e, "problem_type", BearingProblem) is BearingProblem]
PASSIVE += VARIANTS
SCALES = np.array([1.0, 1e-3, 1e-3] * 2)


def rng():
    return np.random.default_rng(17)


def test_discovery_finds_the_estimators():
    expected = {"ExtendedKalman", "Irls", "LeastSquares", "Lms", "Recursive", "RecursiveTls"}
    assert expected <= set(public_classes(probreg.estimators))


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_noiseless_linear_data_give_the_truth(estimator):
    problem, theta = linear_problem(1, n=200, noise=0.0)
    estimate = estimator.estimate(problem, rng=rng())
    # a recursion starts from a diffuse, not an empty, state: 1 / omega remains
    tolerance = 1e-4 if isinstance(estimator, Recursive) else 1e-8
    np.testing.assert_allclose(estimate.theta, theta, atol=tolerance)
    assert estimate.names == problem.names
    assert estimate.converged


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_noiseless_polar_reports_give_the_bias(estimator):
    # radars so accurate that the unbiased factors, which presume noise, are 1 to 3e-10; the
    # bias is then 25 sigma, so laws that reject are started near it
    sharp = tuple(
        dataclasses.replace(r, sigma_range=1.0, sigma_azimuth=2e-5, sigma_elevation=2e-5)
        for r in radar_pair()
    )
    data = polar_reports(sharp, PAIR_BIAS, seed=3, n=300, noise=0.0)
    problem, start = ReportProblem(data), None
    law = getattr(estimator, "noise", None)
    if isinstance(estimator, Recursive) and law is not None and not law.proper:
        start = GaussianPrior.from_sd(10.0 * SCALES, PAIR_BIAS + 0.01 * SCALES)
    if isinstance(estimator, Irls) and not law.proper:
        estimator = dataclasses.replace(estimator, start=Lms())
    estimate = estimator.estimate(problem, start, rng=rng())
    np.testing.assert_allclose(estimate.theta / SCALES, PAIR_BIAS / SCALES, atol=1e-3)


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_swapping_the_sensors_swaps_the_answer(estimator):
    data = polar_reports(radar_pair(), PAIR_BIAS, seed=4, n=300)
    swapped = type(data)(data.sensors[::-1], data.values[::-1], data.time)
    one = estimator.estimate(ReportProblem(data), rng=rng())
    two = estimator.estimate(ReportProblem(swapped), rng=rng())
    assert two.names == one.names[3:] + one.names[:3]
    np.testing.assert_allclose(np.roll(two.theta, 3) / SCALES, one.theta / SCALES, atol=2e-3)


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_the_order_of_three_sensors_does_not_matter(estimator):
    # component-wise laws would see another choice of contrasts
    sensors = (
        Radar2D((0.0, 0.0), 20.0, 2e-3, name="a"),
        Radar2D((9e3, 1e3), 30.0, 3e-3, name="b"),
        Radar2D((2e3, 8e3), 25.0, 2e-3, name="c", from_north=True),
    )
    bias = np.array([30.0, 4e-3, -20.0, 2e-3, 10.0, -5e-3])
    data = polar_reports(sensors, bias, seed=10, n=200)
    other = type(data)(data.sensors[::-1], data.values[::-1], data.time)
    one = estimator.estimate(ReportProblem(data), rng=rng())
    two = estimator.estimate(ReportProblem(other), rng=rng())
    at = [one.names.index(name) for name in two.names]
    scale = np.array([1.0, 1e-3] * 3)
    np.testing.assert_allclose(two.theta / scale, one.theta[at] / scale, atol=1e-6)


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_the_unit_of_a_parameter_does_not_matter(estimator):
    problem, _theta = linear_problem(2, n=300)
    factor = np.array([1.0, 1e3, 1.0, 1e-2])
    other = LinearProblem(problem.y, problem.B / factor, problem.R)
    # omega is a variance in the problem's units, so a recursion is given its start
    start = None, None
    if isinstance(estimator, Recursive):
        start = tuple(GaussianPrior.from_sd(30.0 * f) for f in (np.ones(4), factor))
    one = estimator.estimate(problem, start[0], rng())
    two = estimator.estimate(other, start[1], rng())
    np.testing.assert_allclose(two.theta / factor, one.theta, rtol=0, atol=1e-6)


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_same_seed_same_answer(estimator, small_ralad):
    data, truth = small_ralad
    problem = ReportProblem(data).one_shot([truth.positions])
    one, two = (estimator.estimate(problem, rng=rng()) for _ in range(2))
    np.testing.assert_array_equal(one.theta, two.theta)
    np.testing.assert_array_equal(one.weights, two.weights)


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_weights_have_the_documented_shape(estimator):
    problem, _ = linear_problem(6, n=90)
    weights = estimator.estimate(problem, rng=rng()).weights
    assert weights.shape in {(90,), (90, 3)}
    assert (weights >= 0.0).all()


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_what_the_data_do_not_determine_is_refused_by_name(estimator):
    first, second = radar_pair()
    same = type(first)(
        first.position, second.sigma_range, second.sigma_azimuth, second.sigma_elevation, "j"
    )
    data = polar_reports((first, same), PAIR_BIAS, seed=8)
    # noise in the evaluation points of the one-shot form must not pass for information
    for problem in (ReportProblem(data), ReportProblem(data).one_shot()):
        with pytest.raises(UnobservableError, match=r"i\.range \+ j\.range"):
            estimator.estimate(problem, rng=rng())


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_fewer_rows_than_parameters_is_refused(estimator):
    problem, _ = linear_problem(9, n=1, m=3, p=4)
    with pytest.raises((UnobservableError, InvalidInputError), match=r"3 equations|subset"):
        estimator.estimate(problem, rng=rng())


@pytest.mark.parametrize("estimator", ALL, ids=repr)
def test_printing_an_estimate_names_the_unknowns(estimator):
    problem, _ = linear_problem(10, n=100)
    text = str(estimator.estimate(problem, rng=rng()))
    assert all(name in text for name in problem.names)


# -- bearings ------------------------------------------------------------------------------


def passive(seed=1, **kwargs):
    return BearingProblem.of(passive_reports(seed, **kwargs))


@pytest.mark.parametrize("estimator", PASSIVE, ids=repr)
def test_noiseless_bearings_give_the_emitter(estimator):
    estimate = estimator.estimate(passive(noise=0.0), rng=rng())
    # recursions start diffuse, and total least squares takes one power step a line
    exact = not isinstance(estimator, Recursive) and estimate.path is None
    np.testing.assert_allclose(estimate.theta, EMITTER, atol=1e-3 if exact else 2.0)
    assert estimate.converged


@pytest.mark.parametrize("estimator", PASSIVE, ids=repr)
def test_turning_the_scene_turns_the_emitter(estimator):
    reports = passive_reports(2)
    angle, shift = 2.5, np.array([4e3, -7e3])  # across the cut of the angles
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    # total least squares depends on the origin, and is only turned
    move = shift if getattr(estimator, "takes_prior", True) else np.zeros(2)
    turned = BearingReports(
        reports.sensor, reports.bearing + angle - 2.0 * np.pi, reports.own_position @ turn.T + move
    )
    one = estimator.estimate(BearingProblem.of(reports), rng=rng())
    two = estimator.estimate(BearingProblem.of(turned), rng=rng())
    tolerance = 0.05 * np.sqrt(np.diag(one.covariance)).max() if one.covariance is not None else 1.0
    np.testing.assert_allclose(two.theta, turn @ one.theta + move, atol=max(tolerance, 0.01))


@pytest.mark.parametrize("estimator", PASSIVE, ids=repr)
def test_bearings_from_north_give_the_same_emitter(estimator):
    estimates = [
        estimator.estimate(passive(seed=3, from_north=north), rng=rng()) for north in (False, True)
    ]
    np.testing.assert_allclose(estimates[1].theta, estimates[0].theta, atol=1e-3)


@pytest.mark.parametrize("estimator", PASSIVE, ids=repr)
def test_bearings_are_read_as_they_are(estimator):
    estimate = estimator.estimate(passive(seed=4), rng=rng())
    again = estimator.estimate(passive(seed=4), rng=rng())
    np.testing.assert_array_equal(again.theta, estimate.theta)
    assert estimate.names == ("emitter.x", "emitter.y")
    assert estimate.weights.shape in {(60,), (60, 1)}
    assert np.linalg.norm(estimate.theta - EMITTER) < 500.0
    assert "emitter.x" in str(estimate)


@pytest.mark.parametrize("estimator", PASSIVE, ids=repr)
def test_bearings_along_the_track_are_refused(estimator):
    own = np.stack([300.0 * np.arange(40.0), np.zeros(40)], axis=1)
    sensor = BearingSensor(2e-3)
    noise = sensor.sample_noise(rng(), 40)
    problem = BearingProblem.of(BearingReports(sensor, noise, own))
    with pytest.raises(UnobservableError, match=r"across the line of sight"):
        estimator.estimate(problem, rng=rng())


@pytest.mark.parametrize("estimator", ANY, ids=repr)
def test_no_estimator_builds_a_posterior(estimator, monkeypatch):
    def refuse(self):
        raise AssertionError("a density was built")

    monkeypatch.setattr(Posterior, "__post_init__", refuse)
    problem, _ = linear_problem(6, n=90)
    estimator.estimate(problem, rng=rng())
    with pytest.raises(AssertionError, match="a density"):  # negative control
        Posterior(problem, LAWS[0])
