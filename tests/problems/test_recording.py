"""Recordings as tracks: equations against simulated reports, coverage, and what is refused."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest
from scipy import stats

from probreg import BearingSensor, PositionSensor, Tracker2D
from probreg.errors import InvalidInputError
from probreg.noise import Gaussian
from probreg.posterior.tracks import fit_tracks
from probreg.prior import GaussianPrior
from probreg.problems.recording import recording_problem
from probreg.problems.recording.track_reports import PathPoints
from probreg.recordings import correct, restore
from probreg.registration import LawChoice
from probreg.registration._observed import determined, determined_by
from probreg.registration._track_model import track_model
from tests.registration.conftest import ANGLE, fly, sensors_2d, sensors_3d, vector

OFFSETS = {"a.range": 40.0, "a.azimuth": 4e-3, "b.range": -30.0, "b.azimuth": -5e-3}
EVERYTHING = OFFSETS | {
    "a.range_gain": 6e-4,
    "b.azimuth_sine": 2e-3,
    "b.azimuth_cosine": -1e-3,
    "b.time": 0.4,
}
HIGH = OFFSETS | {"a.elevation": 2e-3, "b.elevation": -1e-3, "a.time": -0.3}
SEEN = OFFSETS | {"eye.bearing": 6e-3, "eye.time": 0.2}
MOVING = {"a.range": 40.0, "platform.heading": 8e-3, "b.range": -20.0, "b.azimuth": 3e-3}
KNOWN = LawChoice(Gaussian())


def with_bearings():
    a, b, _ = sensors_2d()
    return a, BearingSensor(ANGLE, "eye", from_north=True), b


def trackers():
    return (
        Tracker2D((0.0, 0.0), 40.0, "a"),
        Tracker2D((30e3, 5e3), 60.0, "b", from_north=True),
        PositionSensor.independent((20.0, 30.0), "c"),
    )


CASES = {
    "offsets": (sensors_2d(), OFFSETS, {}),
    "all terms": (sensors_2d(), EVERYTHING, {}),
    "3-D": (sensors_3d(), HIGH, {}),
    "bearings": (with_bearings(), SEEN, {}),
    "trackers": (trackers(), OFFSETS, {}),
    "platform": (sensors_2d(), MOVING, {"own_speed": (10.0, -5.0), "body_frame": ("a",)}),
}


def true_path(made, problem):
    """Where targets are at the true times of the problem's reports."""
    late = [made.theta.get(f"{s.name}.time", 0.0) for s in made.recording.sensors]
    time = problem.reports.time - np.array(late)[problem.sensor]
    start, velocity = made.paths
    target = made.recording.target[problem.rows]
    return PathPoints(time, start[target] + velocity[target] * time[:, None], velocity[target])


def misfit(made, theta, at):
    """What equations tangent at the true path of `at` leave of the reports of `made`."""
    problem = recording_problem(made.recording, made.setup)
    equations = problem.reports.linearise(theta, true_path(at, problem)).equations
    position = true_path(at, problem).position[
        problem.reports.linearise(theta, true_path(at, problem)).rows
    ]
    said = np.einsum("ed,ed->e", equations.h, position[equations.report])
    return equations.y - said, equations


@pytest.mark.parametrize("case", CASES)
def test_without_noise_nothing_is_left_at_the_truth_only(case):
    sensors, theta, options = CASES[case]
    made = fly(sensors, theta, noise=0.0, **options)
    truth = vector(made, recording_problem(made.recording, made.setup).names)
    left, _ = misfit(made, truth, made)
    # true positions shift by velocity where clocks are off: rounding only
    assert np.abs(left).max() < 1e-4
    left, _ = misfit(made, 0.0 * truth, made)
    assert np.abs(left).max() > 30.0


@pytest.mark.parametrize("case", CASES)
def test_responses_are_what_the_simulation_answers(case):
    """Reports simulated with a bias a little larger move the equations by its column."""
    sensors, theta, options = CASES[case]
    made = fly(sensors, theta, noise=0.0, **options)
    names = recording_problem(made.recording, made.setup).names
    truth = vector(made, names)
    _, equations = misfit(made, truth, made)
    for k, name in enumerate(names):
        step = 1e-3 if name.endswith("time") else 1e-5 if theta[name] < 0.1 else 0.1
        more = fly(sensors, theta | {name: theta[name] + step}, noise=0.0, **options)
        moved, _ = misfit(more, truth, made)
        column = (equations.response * (equations.column == k)).sum(axis=1)
        size = np.abs(column).max()
        # a clock moves reports along the path: the order of stamps must not change
        if moved.shape == column.shape:
            away = np.abs(moved / step - column)
            assert np.quantile(away, 0.99) < 2e-3 * size, name


def fitted(made):
    problem = recording_problem(made.recording, made.setup)
    model = dataclasses.replace(
        track_model(problem, KNOWN), wrong_share=0.0, acceleration_log_sd=0.0
    )
    return problem, fit_tracks(model)


@pytest.mark.parametrize("case", ["offsets", "bearings", "trackers", "clock"])
def test_fits_of_clean_recordings_cover(case):
    sensors, theta, options = CASES.get(case) or (
        sensors_2d(),
        OFFSETS | {"b.time": 0.4},
        {"periods": (0.5, 0.6, 0.7)},
    )
    recordings, total = 30, 0.0
    for seed in range(recordings):
        made = fly(sensors, theta, seed=seed, targets=10, scans=8, **options)
        problem, fit = fitted(made)
        away = fit.theta - vector(made, problem.names)
        total += away @ np.linalg.solve(fit.covariance, away)
    # pooled z^2 is chi-square; false alarm 1e-3
    low, high = stats.chi2.ppf([5e-4, 1 - 5e-4], recordings * len(problem.names))
    assert low < total < high
    assert not low < 1.3**2 * total < high  # the control: errors 1.3 times as large


def test_a_heading_that_is_missing_is_refused():
    sensors, theta, options = CASES["platform"]
    made = fly(sensors, theta, **options)
    assert "platform.heading" in recording_problem(made.recording, made.setup).names
    blind = dataclasses.replace(made.recording, heading=None)
    with pytest.raises(InvalidInputError, match="counts azimuth from the platform's heading"):
        recording_problem(blind, made.setup)


def test_correcting_and_restoring_a_recording():
    made = fly(sensors_2d(), EVERYTHING)
    theta = vector(made, recording_problem(made.recording, made.setup).names)
    corrected = correct(made.recording, made.setup, theta)
    clean = fly(sensors_2d(), dict.fromkeys(EVERYTHING, 0.0)).recording
    np.testing.assert_allclose(corrected.time, clean.time, atol=1e-9)
    back = restore(corrected, made.setup, theta)
    np.testing.assert_array_equal(back.sensor, made.recording.sensor)
    np.testing.assert_allclose(back.time, made.recording.time, atol=1e-12)
    np.testing.assert_allclose(back.values, made.recording.values, rtol=1e-14, atol=1e-12)


def test_a_target_that_was_away_for_long_has_two_tracks():
    made = fly(sensors_2d(), OFFSETS, targets=3, scans=20)
    recording = made.recording
    late = recording.time > 40.0
    away = dataclasses.replace(recording, time=recording.time + np.where(late, 3_600.0, 0.0))
    problem = recording_problem(away, made.setup)
    assert problem.owner.tolist() == [0, 0, 1, 1, 2, 2]
    track = problem.reports.target
    assert (problem.owner[track] == recording.target[problem.rows]).all()
    assert (track % 2 == late[problem.rows]).all()


def test_what_cannot_be_registered_is_said():
    made = fly(sensors_2d(), OFFSETS)
    rec, setup = made.recording, made.setup
    apart = dataclasses.replace(rec, target=rec.target + 100 * rec.sensor)
    with pytest.raises(InvalidInputError, match="no target was seen by two of the sensors"):
        recording_problem(apart, setup)
    only = np.flatnonzero(rec.sensor == 0)
    one = dataclasses.replace(
        rec,
        **{n: getattr(rec, n)[only] for n in ("sensor", "time", "values", "target")},
    )
    with pytest.raises(InvalidInputError, match=r"1 sensor\(s\) \['a'\]"):
        recording_problem(one, setup)
    shifted = rec.time + 1e5 * rec.sensor
    order = np.argsort(shifted)
    late = dataclasses.replace(
        rec,
        time=shifted[order],
        **{n: getattr(rec, n)[order] for n in ("sensor", "values", "target")},
    )
    with pytest.raises(InvalidInputError, match="clocks have one zero"):
        recording_problem(late, setup)
    strange = dataclasses.replace(setup, biases={"a": ("rnage",)})
    with pytest.raises(InvalidInputError, match="has no bias 'rnage'; it can have azimuth"):
        recording_problem(rec, strange)
    with pytest.raises(InvalidInputError, match="no bias to estimate"):
        recording_problem(rec, dataclasses.replace(setup, biases={}))


def test_what_only_the_reference_tells_is_spelt():
    # two radars at one place, without a reference: only differences of their biases show
    radar = sensors_2d()[0]
    made = fly((radar, dataclasses.replace(radar, name="b")), OFFSETS)
    problem, fit = fitted(made)
    found = determined_by(fit, problem.names)
    assert found.hidden == ["a.azimuth + b.azimuth"]
    # targets fly straight but for a little: the sum of ranges shows, but hardly
    assert len(found.weak) == 2
    for part in ("azimuth", "range"):
        # their sum, whichever of the two is the larger by a thousandth
        pattern = rf"(0\.999 |1 )?a\.{part} \+ (0\.999 |1 )?b\.{part}"
        assert sum(bool(re.fullmatch(pattern, text)) for text in found.weak) == 1, found.weak
    assert (found.share < 0.9).all()
    # in prior standard deviations: a prior of the second azimuth half as wide counts it double
    sd = problem.prior_sd.copy()
    sd[problem.names.index("b.azimuth")] *= 0.5
    parts = fit.information.precision, GaussianPrior.from_sd(sd), problem.names, 100
    assert determined(*parts).hidden == ["0.5 a.azimuth + b.azimuth"]
    # what is less than a twentieth of the largest is left out
    sd[problem.names.index("b.azimuth")] *= 0.02
    parts = fit.information.precision, GaussianPrior.from_sd(sd), problem.names, 100
    assert determined(*parts).hidden == ["b.azimuth"]
