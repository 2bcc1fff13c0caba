"""Every bias term: its column is a derivative, and what it adds can be taken out exactly."""

from __future__ import annotations

import numpy as np
import pytest

from probreg import PositionSensor, Radar2D, Radar3D
from probreg.errors import InvalidInputError
from probreg.terms import add_terms, known_terms, remove_terms

SENSORS = (
    Radar2D((0.0, 0.0), 20.0, 2e-3, "flat"),
    Radar3D((10.0, 20.0, 30.0), 20.0, 2e-3, 2e-3, "high", from_north=True),
    PositionSensor(((100.0, 0.0), (0.0, 100.0)), "gps"),
)
TERMS = [term for sensor in SENSORS for term in known_terms(sensor).values()]
IDS = [f"{term.sensor.name}.{term.name}" for term in TERMS]


def true_reports(sensor, n=50):
    rng = np.random.default_rng(3)
    return sensor.to_report(rng.uniform(3e3, 9e4, (n, sensor.dim)))


@pytest.mark.parametrize("term", TERMS, ids=IDS)
def test_the_column_is_the_derivative_of_the_report(term):
    reports = true_reports(term.sensor)
    step = 1e-3 * term.prior_sd
    ends = [add_terms([term], np.array([s * step]), reports) for s in (1.0, -1.0)]
    np.testing.assert_allclose((ends[0] - ends[1]) / (2.0 * step), term.column(reports), atol=1e-6)
    assert term.unit in ("m", "rad", "s", "m/m")
    moves = np.any(term.column(reports) != 0.0) or term.stamp != 0.0
    assert moves, "a term that does nothing cannot be estimated"


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda s: s.name)
def test_taking_terms_out_and_putting_them_back_is_exact(sensor):
    terms = list(known_terms(sensor).values())
    rng = np.random.default_rng(4)
    theta = 3.0 * np.array([t.prior_sd for t in terms]) * rng.standard_normal(len(terms))
    reports = true_reports(sensor)
    biased = add_terms(terms, theta, reports)
    assert np.abs(biased - reports).max() > 1.0
    size = np.maximum(np.abs(reports), 1.0)
    back = remove_terms(terms, theta, biased)
    assert (np.abs(back - reports) <= 1e-14 * size).all()
    assert (np.abs(add_terms(terms, theta, back) - biased) <= 1e-14 * size).all()


def test_signs_and_sizes_by_hand():
    radar = SENSORS[1]
    terms = known_terms(radar)
    report = np.array([[50e3, 0.3, 0.1]])
    np.testing.assert_allclose(terms["range_gain"].column(report), [[50e3, 0.0, 0.0]])
    np.testing.assert_allclose(terms["azimuth_sine"].column(report), [[0.0, np.sin(0.3), 0.0]])
    np.testing.assert_allclose(terms["azimuth_cosine"].column(report), [[0.0, np.cos(0.3), 0.0]])
    # azimuth from north is clockwise: a heading that reads high turns it the other way
    np.testing.assert_allclose(terms["heading"].column(report), [[0.0, -1.0, 0.0]])
    assert terms["time"].stamp == 1.0
    assert "range_gain" not in known_terms(SENSORS[2])


def test_coefficients_that_are_no_biases_are_refused():
    radar = SENSORS[0]
    term = known_terms(radar)["range_gain"]
    with pytest.raises(InvalidInputError, match=r"flat.range_gain 1.5"):
        remove_terms([term], np.array([1.5]), true_reports(radar))
