"""The mode of track posteriors: at the bound of an oracle, whatever is wrong with the reports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from sklearn.metrics import roc_auc_score

from probreg.errors import InvalidInputError
from probreg.noise import Contaminated, Gaussian, Huber, StudentT
from probreg.posterior.tracks import TrackModel, accelerations, fit_tracks
from probreg.posterior.tracks import fit as fit_module
from probreg.prior import GaussianPrior
from probreg.problems.recording.sensor_model import SensorModel
from probreg.problems.recording.track_reports import TrackReports
from probreg.scenarios import _flights
from probreg.sensors.axes import EARTH_RADIUS_M, HeightAxes, PolarAxes
from tests.posterior.traffic_tracks import draw, model_of, not_as_said, oracle_sd
from tests.problems.test_track_reports import Constant

LIMIT = stats.norm.isf(0.5e-4)  # one false alarm in ten thousand numbers


@pytest.fixture(scope="module")
def mixed():
    """20 % of pairs wrong, 5 % outliers."""
    recording, setup, truth = draw(0, wrong_share=0.2, outlier_share=0.05)
    model, _ = model_of(recording, setup, wrong_share=0.05)
    return recording, truth, model, fit_tracks(model)


def errors(fit, truth):
    return (fit.theta - np.array(list(truth.bias.values()))) / fit.sd


@pytest.mark.parametrize("outliers", [0.0, 0.05])
def test_standard_deviations_are_those_of_an_oracle(outliers):
    recording, setup, truth = draw(1, outlier_share=outliers)
    model, _ = model_of(recording, setup)
    fit = fit_tracks(model)
    ratio = fit.sd / oracle_sd(model, truth, fit.point.density)
    assert ratio.max() < 1.02
    assert ratio.min() > 0.95
    assert np.abs(errors(fit, truth)).max() < LIMIT
    assert fit.settled


def test_reports_under_a_wrong_name_are_given_back_and_cost_nothing(mixed):
    recording, truth, model, fit = mixed
    ratio = fit.sd / oracle_sd(model, truth, fit.point.density)
    assert ratio.min() > 0.95
    assert ratio.max() < 1.02
    assert np.abs(errors(fit, truth)).max() < LIMIT
    moved = fit.target != recording.target
    named_wrong = recording.target != truth.target
    assert (fit.target[moved] == truth.target[moved]).all()
    assert moved.sum() > 0.85 * named_wrong.sum()


def test_single_bad_reports_are_found(mixed):
    recording, truth, _, fit = mixed
    bad = not_as_said(recording, fit)
    named_wrong = recording.target != truth.target
    good = ~named_wrong & ~truth.outlier
    assert roc_auc_score(named_wrong[named_wrong | good], bad[named_wrong | good]) > 0.998
    assert roc_auc_score(~good, bad) > 0.995
    # an outlier of ten times the noise may land among the good: 100 / 101 is the most there is
    assert roc_auc_score(truth.outlier[~named_wrong], bad[~named_wrong]) > 0.98
    assert (bad[good] > 0.5).mean() < 0.002


def test_without_names_that_may_be_wrong_they_pull(mixed):
    """The negative control: the same recording, identities believed."""
    recording, setup, truth = draw(0, wrong_share=0.2, outlier_share=0.05)
    model, _ = model_of(recording, setup, Gaussian(), unknown=(frozenset(),) * 3)
    assert np.abs(errors(fit_tracks(model), truth)).max() > 10.0


def test_many_reports_are_fitted_from_some(mixed, monkeypatch):
    _, _, model, fit = mixed
    monkeypatch.setattr(fit_module, "FIRST_REPORTS", 1500)
    monkeypatch.setattr(accelerations, "MANY_REPORTS", 1500)
    again = fit_tracks(model)
    assert np.abs((again.theta - fit.theta) / fit.sd).max() < 0.1
    np.testing.assert_allclose(again.sd, fit.sd, rtol=0.02)


def test_a_fit_of_other_targets_is_a_start(mixed):
    model, fit = mixed[2], mixed[3]
    some = fit_tracks(model.of_targets(np.arange(0, model.reports.num_targets, 2)))
    again = fit_tracks(model, near=some)
    assert np.abs((again.theta - fit.theta) / fit.sd).max() < 0.1
    np.testing.assert_allclose(again.sd, fit.sd, rtol=0.02)
    # under a law of another kind too
    student = replace(model, laws=(StudentT(4.0),) * 3, unknown=None)
    whole, near = fit_tracks(student), fit_tracks(student, near=some)
    assert np.abs((near.theta - whole.theta) / whole.sd).max() < 0.1


def test_turns_that_the_setup_does_not_expect_are_followed(monkeypatch):
    """Four times the acceleration, and targets that are nothing but wrong names."""
    monkeypatch.setattr(_flights, "TURN_M_S2", 4.0)
    recording, setup, truth = draw(101, wrong_share=0.2, outlier_share=0.05)
    model, _ = model_of(recording, setup, wrong_share=0.05)
    fit = fit_tracks(model)
    assert fit.settled
    density = fit.point.density * np.ones(fit.model.reports.num_targets)
    assert 15.0 < np.median(density[fit.target]) < 35.0
    assert np.abs(errors(fit, truth)).max() < LIMIT
    good = (recording.target == truth.target) & ~truth.outlier
    assert (not_as_said(recording, fit)[good] > 0.5).mean() < 0.002


@pytest.mark.parametrize("factor", [1.0 / 9.0, 9.0])
def test_an_acceleration_that_the_setup_has_wrong_costs_nothing(mixed, factor):
    _, truth, model, fit = mixed
    other = fit_tracks(replace(model, acceleration=factor))
    np.testing.assert_allclose(other.point.q, fit.point.q, rtol=0.05)
    assert (other.sd / oracle_sd(model, truth, fit.point.density)).max() < 1.02


def formation(seed, gap):
    """Every aircraft with a companion at `gap` metres; names exchanged in 40 % of the looks."""
    rng = np.random.default_rng(seed)
    recording, setup, truth = draw(2000 + seed, reports=2500)
    beside = recording.values.copy()
    for k, sensor in enumerate(recording.sensors):
        own = np.flatnonzero(recording.sensor == k)
        bias = [truth.bias[f"{sensor.name}.{term}"] for term in ("range", "azimuth")]
        where = truth.positions[own, :2] + gap * np.array([np.cos(1.0), np.sin(1.0)])
        beside[own] = sensor.to_report(where) + bias + sensor.sample_noise(rng, len(own))
    K = int(recording.target.max()) + 1
    exchanged = rng.random(len(recording)) < 0.4
    leader, other = recording.target, recording.target + K
    names = np.concatenate([np.where(exchanged, other, leader), np.where(exchanged, leader, other)])
    model, _ = model_of(recording, setup, wrong_share=0.05)
    both = {name: np.tile(getattr(model.reports, name), 2) for name in ("sensor", "time")}
    values = np.vstack([recording.values, beside])
    reports = replace(model.reports, **both, target=names, values=values)
    return replace(model, reports=reports, guess=None), truth, leader


@pytest.mark.parametrize("gap", [300.0, 1500.0])
def test_exchanged_names_in_close_formations_do_not_pull(gap):
    z = []
    for seed in range(3):
        model, truth, leader = formation(seed, gap)
        fit = fit_tracks(model)
        z.append(errors(fit, truth))
        if gap > 1000.0:
            # pairs come apart: each target keeps the reports of one of the two, mostly
            K = model.reports.num_targets // 2
            first = fit.target[: len(leader)] >= K
            mixed = np.bincount(leader, first, K) / np.maximum(np.bincount(leader, minlength=K), 1)
            assert np.minimum(mixed, 1.0 - mixed)[np.bincount(leader) > 20].mean() < 0.3
    assert np.abs(z).max() < LIMIT


def test_student_noise_is_recognised():
    recording, setup, truth = draw(2)
    rng = np.random.default_rng(5)
    precision = rng.chisquare(4.0, len(recording)) / 4.0
    values = recording.values.copy()
    for k, sensor in enumerate(recording.sensors):
        own = recording.sensor == k
        bias = [truth.bias[f"{sensor.name}.{term}"] for term in ("range", "azimuth")]
        clean = sensor.to_report(truth.positions[own, :2]) + np.array(bias)
        noise = sensor.sample_noise(rng, own.sum()) / np.sqrt(precision[own, None])
        values[own] = clean + noise
    model, _ = model_of(recording, setup, StudentT(10.0))
    model = replace(model, reports=replace(model.reports, values=values), guess=None)
    fit = fit_tracks(model)
    assert np.abs(errors(fit, truth)).max() < LIMIT
    # each sensor's nu within four of its standard errors, some 0.35 of 1700 reports each
    assert np.abs([law.nu - 4.0 for law in fit.point.laws]).max() < 1.4
    np.testing.assert_allclose([law.scale for law in fit.point.laws], 1.0, rtol=0.12)


def test_clocks_of_all_sensors_are_known_relative_to_each_other():
    late = {"radar1.time": 0.4, "radar2.time": -0.3, "radar3.time": 0.1}
    recording, setup, _ = draw(3, biases=late)
    model, names = model_of(recording, setup)
    fit = fit_tracks(model)
    clocks = [names.index(name) for name in late]
    theta, sd = fit.theta[clocks], fit.sd[clocks]
    wanted = np.array(list(late.values()))
    contrast = np.eye(3) - 1.0 / 3.0
    spread = contrast @ fit.covariance[np.ix_(clocks, clocks)] @ contrast
    z = (contrast @ (theta - wanted)) / np.sqrt(np.diag(spread))
    assert np.abs(z).max() < LIMIT
    # each alone is as uncertain as the prior of their mean, half a second over root three
    np.testing.assert_allclose(sd, 0.5 / np.sqrt(3.0), rtol=0.05)


def spatial(seed, delay_sd=0.0, n=1500, heights=True):
    """Level, climbing aircraft over a round earth, slant ranges and reported heights.

    Three radars of (slant range, azimuth) with range biases, one constant a target.
    """
    rng = np.random.default_rng(seed)
    K, span = 15, 400.0
    start = np.column_stack([rng.uniform(-60e3, 60e3, (K, 2)), rng.uniform(4e3, 11e3, K)])
    speed = np.column_stack([rng.normal(0.0, 150.0, (K, 2)), rng.normal(0.0, 3.0, K)])
    target, time = rng.integers(0, K, n), rng.uniform(0.0, span, n)
    flat = start[target] + time[:, None] * speed[target]
    # heights above a sphere: the frame is a tangent plane
    ground = np.hypot(flat[:, 0], flat[:, 1])
    angle = ground / EARTH_RADIUS_M
    out = EARTH_RADIUS_M + flat[:, 2]
    x = np.column_stack(
        [
            out * np.sin(angle) * flat[:, 0] / ground,
            out * np.sin(angle) * flat[:, 1] / ground,
            out * np.cos(angle) - EARTH_RADIUS_M,
        ]
    )
    true, sigmas = np.array([80.0, -50.0, 20.0]), np.array([30.0, 1e-3])
    places = 40e3 * np.array([[1.0, 0.0, 0.0], [-0.5, 0.8, 0.0], [-0.5, -0.8, 0.0]])
    axes = [PolarAxes(p, ("range", "azimuth")) for p in places]
    own = ((0, Constant(0)),) if delay_sd else ()
    models = tuple(SensorModel(a, sigmas, ((k, Constant(0)),), own) for k, a in enumerate(axes))
    sensor = rng.integers(0, 3, n)
    values = np.stack([a.observe(x).value for a in axes])[sensor, np.arange(n)]
    values += rng.normal(size=(n, 2)) * sigmas
    delay = delay_sd * rng.standard_normal(K)
    values[:, 0] += true[sensor] + delay[target]
    if heights:
        level = SensorModel(Sphere(), np.array([15.0]))
        high = np.column_stack([flat[:, 2] + 15.0 * rng.normal(size=n), np.full(n, np.nan)])
        models, values = (*models, level), np.vstack([values, high])
        sensor = np.concatenate([sensor, np.full(n, 3)])
        target, time = np.tile(target, 2), np.tile(time, 2)
    reports = TrackReports(
        models, sensor, target, time, values, 3, 3, 1 if delay_sd else 0, EARTH_RADIUS_M
    )
    return reports, true


class Sphere(HeightAxes):
    """Heights above a sphere."""

    def observe(self, x):
        away = x + np.array([0.0, 0.0, EARTH_RADIUS_M])
        distance = np.linalg.norm(away, axis=1, keepdims=True)
        seen = super().observe(x)
        return seen._replace(
            value=distance - EARTH_RADIUS_M, gradient=(away / distance)[:, None, :]
        )


def fit_spatial(reports, **options):
    laws = (Contaminated(0.02, 10.0),) * len(reports.models)
    prior = GaussianPrior.from_sd(np.full(3, 300.0))
    options = {"acceleration": 0.01, **options}
    return fit_tracks(TrackModel(reports, prior, laws, **options))


@pytest.mark.parametrize("heights", [True, False])
def test_slant_ranges_and_heights_over_a_round_earth(heights):
    reports, true = spatial(4, heights=heights)
    fit = fit_spatial(reports)
    assert np.abs((fit.theta - true) / fit.sd).max() < LIMIT
    assert fit.sd.max() < (10.0 if heights else 60.0)


def test_delays_of_targets_are_constants_with_a_spread_of_their_own():
    reports, true = spatial(5, delay_sd=40.0)
    fit = fit_spatial(reports, constant_sd=(20.0,))
    assert np.abs((fit.theta - true) / fit.sd).max() < LIMIT
    # fifteen targets: the sample spread of 40 within three of its standard errors
    assert fit.point.constant_sd[0] == pytest.approx(40.0, rel=3.0 / np.sqrt(2.0 * 15.0))


def test_models_that_cannot_be_are_refused(mixed):
    model = mixed[2]
    for change, message in (
        ({"laws": model.laws[:2]}, "3 scale-mixture laws"),
        ({"laws": (Huber(),) * 3}, "3 scale-mixture laws"),
        ({"laws": (StudentT(4.0, componentwise=True),) * 3}, "whole reports"),
        ({"prior": GaussianPrior.from_sd(np.ones(2))}, "6 biases"),
        ({"wrong_share": 1.0}, "share below 1"),
        ({"constant_sd": (1.0,)}, "0 constants"),
        ({"area_m2": 0.0}, "area_m2"),
    ):
        with pytest.raises(InvalidInputError, match=message):
            replace(model, **change)
