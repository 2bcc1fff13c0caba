"""Residuals of single reports, and how numbers are shown."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.noise import Gaussian
from probreg.page._units import decimals, number, percent
from probreg.posterior.tracks import fit_tracks
from probreg.problems.recording import recording_problem
from probreg.registration import LawChoice
from probreg.registration._track_model import track_model
from probreg.registration.residuals import components, report_residuals, spread
from tests.registration.conftest import fly, sensors_2d, sensors_3d

GAUSSIAN = LawChoice(Gaussian())
OFFSETS = {"a.range": 40.0, "a.azimuth": 4e-3, "b.range": -30.0, "b.azimuth": -5e-3, "b.time": 0.4}


def fitted(made, recording=None):
    """The tracks of a made recording, and residuals of its reports at the mode."""
    problem = recording_problem(made.recording if recording is None else recording, made.setup)
    fit = fit_tracks(track_model(problem, GAUSSIAN))
    return problem, report_residuals(problem, fit)


@pytest.mark.parametrize("sensors", [sensors_2d(), sensors_3d()], ids=["2-D", "3-D"])
def test_without_noise_on_straight_paths_nothing_is_left(sensors):
    made = fly(sensors, OFFSETS, noise=0.0)
    problem, residuals = fitted(made)
    found = components(problem, residuals)
    assert {(one.sensor, one.name) for one in found} >= {("a", "range"), ("b", "azimuth")}
    for one in found:
        # the priors of the biases pull by a few parts in a thousand
        assert np.abs(one.after).max() < (2.0 if one.unit == "m" else 2e-4)
        assert len(one.rows) > 50


def test_a_bias_of_one_sensor_is_seen_where_the_others_have_none():
    # oracle: beside an unbiased reference the residual before correction is the bias itself
    a, _, c = sensors_2d()
    made = fly((a, c), {"a.range": 40.0, "a.azimuth": 4e-3}, noise=0.0, periods=(4.0, 5.0))
    found = {(one.sensor, one.name): one for one in components(*fitted(made))}
    assert spread(found["a", "range"].before).median == pytest.approx(40.0, abs=0.5)
    assert spread(found["a", "azimuth"].before).median == pytest.approx(4e-3, rel=1e-2)
    assert spread(found["c", "x"].before).median == pytest.approx(0.0, abs=0.5)


@pytest.mark.parametrize("sensors", [sensors_2d(), sensors_3d()], ids=["2-D", "3-D"])
def test_residuals_are_as_large_as_their_standard_deviations_claim(sensors):
    # 750 residuals a component, robust spread: 0.12 is three standard errors
    made = fly(sensors, OFFSETS, targets=250, scans=3)
    found = components(*fitted(made))
    for one in found:
        assert spread(one.after / one.sd).sd == pytest.approx(1.0, abs=0.12)
    # control: where the path is not much better known than the report, its error counts too
    assert max(np.median(one.sd) / declared(made, one) for one in found) > 1.15


def declared(made, one):
    """Declared standard deviation of a component of a sensor, metres or radians."""
    sensor = next(s for s in made.setup.sensors if s.name == one.sensor)
    return sensor.sigmas[sensor.bias_names.index(one.name)]


def test_reports_of_no_target_are_not_compared():
    made = fly(sensors_2d(), OFFSETS)
    target = made.recording.target.copy()
    unknown = np.arange(3, len(target), 7)
    target[unknown] = -1
    problem, found = fitted(made, dataclasses.replace(made.recording, target=target))
    assert np.isnan(found.after[unknown]).all()
    shown = np.concatenate([one.rows for one in components(problem, found)])
    assert set(shown.tolist()) == set(range(len(target))) - set(unknown.tolist())


@pytest.mark.parametrize(
    ("value", "spread_of_it", "text"),
    [
        (12.3456, 1.86, "12.3"),
        (-0.131177, 0.00268, "\N{MINUS SIGN}0.1312"),
        (1234.6, 86.0, "1235"),
        (-0.0004, 0.5, "0.00"),
        (np.nan, 1.0, "not known"),
    ],
)
def test_numbers_show_two_digits_of_their_spread(value, spread_of_it, text):
    assert number(value, decimals(spread_of_it)).text == text


def test_probabilities_claim_no_more_than_draws_tell():
    assert [percent(p).replace("\N{NO-BREAK SPACE}", " ") for p in (0.0, 0.25, 1.0, np.nan)] == [
        "below 0.1 %",
        "25.0 %",
        "above 99.9 %",
        "not known",
    ]
