"""Every bias term: its column is a derivative, and what it adds can be taken out exactly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from probreg import PositionSensor, Radar2D, Radar3D
from probreg.errors import InvalidInputError
from probreg.sensors.geometry import wrap_angle
from probreg.sensors.terms import add_terms, known_terms, remove_terms

SENSORS = (
    Radar2D((0.0, 0.0), 20.0, 2e-3, "flat"),
    Radar3D((10.0, 20.0, 30.0), 20.0, 2e-3, 2e-3, "high", from_north=True),
    PositionSensor(((100.0, 0.0), (0.0, 100.0)), "gps"),
)


def true_reports(sensor, n=50):
    return sensor.to_report(flight(sensor, n)[0])


def flight(sensor, n=50):
    """Where targets are (n, d), and their velocities."""
    rng = np.random.default_rng(3)
    return rng.uniform(3e3, 9e4, (n, sensor.dim)), rng.uniform(-250.0, 250.0, (n, sensor.dim))


# What a sensor reports of targets whose stamp says that they are at x, by the physics of each
# error: functions of sensor, coefficient c, positions x, velocities v and true reports z.


def offset(name):
    def reported(sensor, c, x, v, z):
        z = z.copy()
        z[:, {"range": 0, "azimuth": 1, "elevation": 2, "x": 0, "y": 1, "z": 2}[name]] += c
        return z

    return reported


def stretched(sensor, c, x, v, z):
    # a target that is farther by the share c in the same direction
    place = np.asarray(sensor.position)
    return sensor.to_report(place + (1.0 + c) * (x - place))


def encoder(function):
    def reported(sensor, c, x, v, z):
        return np.column_stack([z[:, 0], z[:, 1] + c * function(z[:, 1]), z[:, 2:]])

    return reported


def swung(sensor, c, x, v, z):
    # the platform believes to be turned by c counter-clockwise: so is all that it sees
    place = np.asarray(sensor.position)
    turn = np.eye(sensor.dim)
    turn[:2, :2] = [[np.cos(c), -np.sin(c)], [np.sin(c), np.cos(c)]]
    return sensor.to_report(place + (x - place) @ turn.T)


def late(sensor, c, x, v, z):
    # a clock ahead by c stamps what was seen c seconds before
    return sensor.to_report(x - c * v)


REPORTED = {
    **{name: offset(name) for name in ("range", "azimuth", "elevation", "x", "y", "z")},
    "range_gain": stretched,
    "azimuth_sine": encoder(np.sin),
    "azimuth_cosine": encoder(np.cos),
    "heading": swung,
    "time": late,
}


# terms whose physics is a test of their own are left out: tests/sensors/test_<name>.py
OWN = Path(__file__).parents[1] / "sensors"
TERMS = [
    term
    for sensor in SENSORS
    for term in known_terms(sensor).values()
    if not (OWN / f"test_{term.name}.py").exists()
]
IDS = [f"{term.sensor.name}.{term.name}" for term in TERMS]


def disagreement(term, reported=None):
    """Largest difference of a term's column and stamp to the physics, in units of the largest."""
    reported = REPORTED[term.name] if reported is None else reported
    sensor, (x, v) = term.sensor, flight(term.sensor)
    z, second, step = sensor.to_report(x), 1e-2, 1e-3 * term.prior_sd
    high, low = (reported(sensor, s * step, x, v, z) for s in (1.0, -1.0))
    wanted = difference(sensor, high, low) / (2.0 * step)
    ends = (sensor.to_report(x + s * second * v) for s in (1.0, -1.0))
    rate = difference(sensor, *ends) / (2.0 * second)
    # at a fixed stamp a later truth is an earlier report
    found = term.column(z) - term.stamp * rate
    # rounding of a range of 100 km over a step of 1e-5 rad is 1e-6
    size = np.maximum(np.abs(wanted).max(axis=0), 1e-2)
    return float(np.abs((found - wanted) / size).max())


def difference(sensor, one, two):
    return np.column_stack(
        [
            wrap_angle(one[:, k] - two[:, k]) if unit == "rad" else one[:, k] - two[:, k]
            for k, unit in enumerate(sensor.bias_units)
        ]
    )


@pytest.mark.parametrize("term", TERMS, ids=IDS)
def test_the_column_is_the_derivative_of_the_report(term):
    assert disagreement(term) < 1e-4
    assert term.unit in ("m", "rad", "s", "m/m")


@pytest.mark.parametrize("term", TERMS, ids=IDS)
def test_a_column_or_stamp_of_another_size_or_sign_is_seen(term):
    for factor in (-1.0, 1.01):
        wrong = type(
            "Wrong",
            (type(term),),
            {
                "column": lambda self, z, factor=factor: factor * term.column(z),
                "stamp": factor * term.stamp,
            },
        )
        assert disagreement(wrong(**vars(term))) > 5e-3


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
