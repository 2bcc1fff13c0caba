"""Residuals of single reports, and how numbers are shown."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.page._units import decimals, number, percent
from probreg.recordings import bias_model
from probreg.registration.residuals import components, report_residuals, spread
from tests.registration.conftest import fly, sensors_2d, sensors_3d

OFFSETS = {"a.range": 40.0, "a.azimuth": 4e-3, "b.range": -30.0, "b.azimuth": -5e-3, "b.time": 0.4}


def both(made):
    names = bias_model(made.setup).names
    truth = np.array([made.theta[name] for name in names])
    before = report_residuals(made.recording, made.setup, np.zeros(len(names)))
    return before, report_residuals(made.recording, made.setup, truth)


@pytest.mark.parametrize("sensors", [sensors_2d(), sensors_3d()], ids=["2-D", "3-D"])
def test_without_noise_on_straight_paths_nothing_is_left_at_the_truth(sensors):
    made = fly(sensors, OFFSETS, noise=0.0)
    before, after = both(made)
    found = components(made.recording, before, after)
    assert {(one.sensor, one.name) for one in found} >= {("a", "range"), ("b", "azimuth")}
    for one in found:
        # the unbiased factors stretch noise-free reports by a few parts in a million
        assert np.abs(one.after).max() < (1.0 if one.unit == "m" else 1e-3)
        assert len(one.rows) > 50


def test_a_bias_of_one_sensor_is_seen_where_the_others_have_none():
    # oracle: with an unbiased reference the residual before correction is the bias itself
    a, _, c = sensors_2d()
    made = fly((a, c), {"a.range": 40.0, "a.azimuth": 4e-3}, noise=0.0, periods=(4.0, 5.0))
    before, after = both(made)
    found = {(one.sensor, one.name): one for one in components(made.recording, before, after)}
    assert spread(found["a", "range"].before).median == pytest.approx(40.0, abs=0.2)
    assert spread(found["a", "azimuth"].before).median == pytest.approx(4e-3, rel=1e-2)


def test_reports_of_other_targets_and_far_in_time_are_not_compared():
    made = fly(sensors_2d(), OFFSETS, targets=1, window_s=0.01)
    before, after = both(made)
    assert components(made.recording, before, after) == []


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
