"""Rows of asynchronous recordings against brute force and finite differences."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats
from scipy.linalg import block_diag

from probreg import BearingSensor, GaussianPrior
from probreg.errors import InvalidInputError
from probreg.estimators import LeastSquares
from probreg.problems.recording import RecordingProblem, plan_rows
from probreg.recordings import correct, restore
from probreg.registration._observed import determined
from tests.registration.conftest import ANGLE, fly, sensors_2d, sensors_3d, vector

OFFSETS = {"a.range": 40.0, "a.azimuth": 4e-3, "b.range": -30.0, "b.azimuth": -5e-3}
EVERYTHING = OFFSETS | {
    "a.range_gain": 6e-4,
    "b.azimuth_sine": 2e-3,
    "b.azimuth_cosine": -1e-3,
    "b.time": 0.4,
}
HIGH = OFFSETS | {"a.elevation": 2e-3, "b.elevation": -1e-3, "a.time": -0.3}


@pytest.mark.parametrize(
    ("sensors", "theta"),
    [(sensors_2d(), OFFSETS), (sensors_2d(), EVERYTHING), (sensors_3d(), HIGH)],
    ids=["offsets", "all terms", "3-D"],
)
def test_without_noise_the_residual_is_zero_at_the_truth_only(sensors, theta):
    made = fly(sensors, theta, noise=0.0)
    problem = RecordingProblem(made.recording, made.setup)
    truth = vector(made, problem.names)
    # the unbiased factors stretch noise-free reports by a few parts in a million
    assert np.abs(problem.residual(truth)).max() < 1.0
    assert np.abs(problem.residual(problem.start)).max() > 50.0


@pytest.mark.parametrize(
    ("sensors", "theta"), [(sensors_2d(), EVERYTHING), (sensors_3d(), HIGH)], ids=["2-D", "3-D"]
)
def test_jacobian_by_finite_differences(sensors, theta):
    made = fly(sensors, theta, noise=0.0)
    problem = RecordingProblem(made.recording, made.setup)
    truth = vector(made, problem.names)
    jacobian = problem.jacobian(truth)
    for k, step in enumerate(1e-2 * problem.scale):
        e = step * np.eye(len(truth))[k]
        numeric = (problem.residual(truth + e) - problem.residual(truth - e)) / (2.0 * step)
        size = np.abs(numeric).max()
        np.testing.assert_allclose(jacobian[..., k], numeric, atol=6e-3 * size)


def test_elimination_is_least_squares_over_biases_and_paths_together():
    # oracle: one dense generalised least squares with every row's position and velocity in it
    made = fly(sensors_2d(), OFFSETS, seed=3, targets=4, scans=4, acceleration_m_s2=3.0)
    problem = RecordingProblem(made.recording, made.setup)
    theta = vector(made, problem.names)
    linear = problem.linearise(theta)
    plan, recording = problem.plan, made.recording
    left, right, noise = [], [], []
    for r in range(len(plan)):
        own = plan.members[plan.start[r] : plan.start[r + 1]]
        time = recording.time[own] - recording.time[own[0]]
        target = plan.target[r]
        where = made.paths[0][target] + made.paths[1][target] * recording.time[own][:, None]
        C, columns, lines = [], [], []
        for i, t, x in zip(own, time, where, strict=True):
            sensor = recording.sensors[recording.sensor[i]]
            C.append(sensor.covariance(x[None])[0])
            column = np.zeros((2, len(theta)))
            for k, name in enumerate(problem.names):
                if name.startswith(sensor.name):
                    column[:, k] = sensor.sensitivity(x[None])[0][:, k % 2]
            columns.append(column)
            lines.append(np.hstack([np.eye(2), t * np.eye(2)]))
        s, t = np.minimum.outer(time, time), np.maximum.outer(time, time)
        path = 9.0 * np.kron(s**2 * (t / 2.0 - s / 6.0), np.eye(2))
        noise.append(block_diag(*C) + path)
        nuisance = np.zeros((2 * len(own), 4 * len(plan)))
        nuisance[:, 4 * r : 4 * r + 4] = np.vstack(lines)
        left.append(np.hstack([np.vstack(columns), nuisance]))
        right.append(np.zeros(2 * len(own)))
    root = np.linalg.inv(np.linalg.cholesky(block_diag(*noise)))
    A = root @ np.vstack(left)
    dense = np.linalg.inv(A.T @ A)[:4, :4]
    got = LeastSquares().estimate(linear).covariance
    # evaluated at the true path there, at the fitted one here: agreement to their difference
    np.testing.assert_allclose(np.sqrt(np.diag(got)), np.sqrt(np.diag(dense)), rtol=0.02)


def test_rows_partition_reports_and_are_short():
    made = fly(sensors_2d(), OFFSETS, targets=30, scans=20, window_s=8.0)
    plan, recording = plan_rows(made.recording, made.setup), made.recording
    assert len(np.unique(plan.members)) == len(plan.members) > 0.7 * len(recording)
    for r in range(len(plan)):
        own = plan.members[plan.start[r] : plan.start[r + 1]]
        assert (recording.target[own] == plan.target[r]).all()
        assert len(np.unique(recording.sensor[own])) > 1
        assert np.ptp(recording.time[own]) <= 8.0
        assert 3 <= len(own) <= 6
        assert np.bincount(recording.sensor[own]).max() <= 2
        assert (np.diff(recording.time[own]) >= 0.0).all()


def test_simultaneous_reports_make_rows_at_rest():
    made = fly(sensors_2d(), OFFSETS, together=True)
    plan = plan_rows(made.recording, made.setup)
    assert (plan.moving == 0).all()
    assert (np.diff(plan.start) == 3).all()
    assert len(plan.members) == len(made.recording)
    # where a clock is in question they tell no velocity: rows then span several scans
    moving = plan_rows(made.recording, made.setup, always_moving=True)
    assert (moving.moving == 1).all()


def pooled(sensors, theta, recordings):
    """Squared errors of least squares in its own covariance, summed over recordings."""
    total = 0.0
    for seed in range(recordings):
        made = fly(sensors, theta, seed=seed, targets=10, scans=8)
        problem = RecordingProblem(made.recording, made.setup)
        got = LeastSquares().estimate(problem)
        away = got.theta - vector(made, problem.names)
        total += away @ np.linalg.solve(got.covariance, away)
    return total


def test_coverage_of_least_squares_on_clean_recordings():
    # 60 recordings, 4 biases: pooled z^2 sums to chi-square of 240; false alarm 1e-4
    low, high = stats.chi2.ppf([5e-5, 1 - 5e-5], 240)
    assert low < pooled(sensors_2d(), OFFSETS, 60) < high


def test_a_moving_platform_and_its_heading():
    theta = {"a.range": 40.0, "platform.heading": 8e-3, "b.range": -20.0, "b.azimuth": 3e-3}
    made = fly(sensors_2d(), theta, noise=0.0, own_speed=(10.0, -5.0), body_frame=("a",), scans=20)
    problem = RecordingProblem(made.recording, made.setup)
    assert "platform.heading" in problem.names
    truth = vector(made, problem.names)
    assert np.abs(problem.residual(truth)).max() < 1.0
    blind = dataclasses.replace(made.recording, heading=None)
    with pytest.raises(InvalidInputError, match="counts azimuth from the platform's heading"):
        RecordingProblem(blind, made.setup)


def test_correcting_and_restoring_a_recording():
    made = fly(sensors_2d(), EVERYTHING)
    problem = RecordingProblem(made.recording, made.setup)
    theta = vector(made, problem.names)
    corrected = correct(made.recording, made.setup, theta)
    clean = fly(sensors_2d(), dict.fromkeys(EVERYTHING, 0.0)).recording
    np.testing.assert_allclose(corrected.time, clean.time, atol=1e-9)
    back = restore(corrected, made.setup, theta)
    np.testing.assert_array_equal(back.sensor, made.recording.sensor)
    np.testing.assert_allclose(back.time, made.recording.time, atol=1e-12)
    np.testing.assert_allclose(back.values, made.recording.values, rtol=1e-14, atol=1e-12)


def with_bearings():
    a, b, _ = sensors_2d()
    return a, BearingSensor(ANGLE, "eye", from_north=True), b


SEEN = OFFSETS | {"eye.bearing": 6e-3, "eye.time": 0.2}


def test_bearings_enter_where_other_reports_place_the_target():
    made = fly(with_bearings(), SEEN, noise=0.0, targets=20)
    problem = RecordingProblem(made.recording, made.setup)
    truth = vector(made, problem.names)
    assert np.abs(problem.linearise(truth).whitened().residual(truth)).max() < 0.2
    eye = problem.recording.sensor[problem.plan.members] == 1
    assert eye.sum() > 50
    assert 0 < (~problem.metric).sum() < len(problem.plan)
    jacobian = problem.jacobian(truth)
    for k, step in enumerate(1e-2 * problem.scale):
        e = step * np.eye(len(truth))[k]
        numeric = (problem.residual(truth + e) - problem.residual(truth - e)) / (2.0 * step)
        away = np.abs(jacobian[..., k] - numeric)
        # a bearing from very near is not linear over the step
        assert np.quantile(away, 0.98) < 6e-3 * np.abs(numeric).max()


def test_least_squares_with_bearings_covers():
    # 40 recordings, 6 unknowns: pooled z^2 is chi-square of 240; false alarm 1e-4
    low, high = stats.chi2.ppf([5e-5, 1 - 5e-5], 240)
    assert low < pooled(with_bearings(), SEEN, 40) < high


def test_a_report_moved_moves_its_own_row_only():
    made = fly(sensors_2d(), OFFSETS)
    problem = RecordingProblem(made.recording, made.setup)
    moved = problem.shifted(3, 1, 1e-3)
    changed = np.abs(moved.residual(problem.start) - problem.residual(problem.start)).max(axis=1)
    assert changed[3] > 0.1
    assert np.delete(changed, 3).max() == 0.0


def test_what_cannot_be_registered_is_said():
    made = fly(sensors_2d(), OFFSETS)
    rec, setup = made.recording, made.setup
    apart = dataclasses.replace(rec, target=rec.target + 100 * rec.sensor)
    with pytest.raises(InvalidInputError, match="no target was seen by two of the sensors"):
        RecordingProblem(apart, setup)
    only = np.flatnonzero(rec.sensor == 0)
    one = dataclasses.replace(
        rec,
        **{n: getattr(rec, n)[only] for n in ("sensor", "time", "values", "target")},
    )
    with pytest.raises(InvalidInputError, match=r"1 sensor\(s\) \['a'\]"):
        RecordingProblem(one, setup)
    shifted = rec.time + 1e5 * rec.sensor
    order = np.argsort(shifted)
    late = dataclasses.replace(
        rec,
        time=shifted[order],
        **{n: getattr(rec, n)[order] for n in ("sensor", "values", "target")},
    )
    with pytest.raises(InvalidInputError, match="clocks have one zero"):
        RecordingProblem(late, setup)
    strange = dataclasses.replace(setup, biases={"a": ("rnage",)})
    with pytest.raises(InvalidInputError, match="has no bias 'rnage'; it can have azimuth"):
        RecordingProblem(rec, strange)
    with pytest.raises(InvalidInputError, match="no bias to estimate"):
        RecordingProblem(rec, dataclasses.replace(setup, biases={}))


def test_what_only_the_reference_tells_is_spelt():
    # two radars at one place, without a reference: only differences of their biases show
    radar = sensors_2d()[0]
    made = fly((radar, dataclasses.replace(radar, name="b")), OFFSETS)
    problem = RecordingProblem(made.recording, made.setup)
    assert problem.observability().combinations() == ["a.azimuth + b.azimuth"]
    prior = GaussianPrior.from_sd(problem.prior_sd)
    rows = problem.linearise(problem.start).whitened().A.reshape(-1, 4)
    found = determined(problem.linearise(problem.start), rows.T @ rows, prior)
    # targets turn a little between reports, which shows the sum of ranges, but hardly
    assert found.hidden == ["a.azimuth + b.azimuth"]
    assert sorted(found.weak) == ["a.azimuth + b.azimuth", "a.range + b.range"]
    assert (found.share < 0.9).all()
    # in prior standard deviations: a prior of the second azimuth half as wide counts it double
    sd = problem.prior_sd.copy()
    sd[problem.names.index("b.azimuth")] *= 0.5
    found = determined(problem.linearise(problem.start), rows.T @ rows, GaussianPrior.from_sd(sd))
    assert found.hidden == ["0.5 a.azimuth + b.azimuth"]
    # what is less than a twentieth of the largest is left out
    sd[problem.names.index("b.azimuth")] *= 0.02
    found = determined(problem.linearise(problem.start), rows.T @ rows, GaussianPrior.from_sd(sd))
    assert found.hidden == ["b.azimuth"]


def test_a_row_of_short_span_borrows_its_velocity_from_its_neighbours():
    # its own velocity is noise, and would pass for information on the clock
    theta = OFFSETS | {"b.time": 0.4}
    made = fly(sensors_2d(), theta, targets=30, scans=20, seed=2)
    problem = RecordingProblem(made.recording, made.setup)
    truth = vector(made, problem.names)
    found = problem._velocities(truth)
    away = np.linalg.norm(found - made.paths[1][problem.plan.target], axis=1)
    assert np.median(away) < 20.0
    assert np.quantile(away, 0.95) < 60.0


@pytest.mark.parametrize("steadied", [True, False])
def test_coverage_of_a_clock_offset(steadied, monkeypatch):
    # 60 recordings: z^2 of the clock alone is chi-square of 60; false alarm 1e-3. The control:
    # with every short row's own velocity the claimed accuracy is too good
    from scipy import stats

    if not steadied:
        monkeypatch.setattr(
            "probreg.problems.recording.recording_problem.steady",
            lambda t, x, velocity, w, r: velocity,
        )
    theta = OFFSETS | {"b.time": 0.4}
    total = 0.0
    for seed in range(60):
        made = fly(sensors_2d(), theta, seed=seed, targets=10, scans=10, periods=(0.5, 0.6, 0.7))
        problem = RecordingProblem(made.recording, made.setup)
        got = LeastSquares().estimate(problem)
        k = problem.names.index("b.time")
        total += (got.theta[k] - 0.4) ** 2 / got.covariance[k, k]
    low, high = stats.chi2.ppf([5e-4, 1 - 5e-4], 60)
    assert (low < total < high) == steadied
