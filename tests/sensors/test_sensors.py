from __future__ import annotations

import numpy as np
import pytest

from probreg import PositionSensor, Radar2D, Radar3D
from probreg.errors import InvalidInputError

ANGLE = np.deg2rad(0.3)
SENSORS = [
    Radar2D((100.0, -50.0), 20.0, ANGLE),
    Radar2D((100.0, -50.0), 20.0, ANGLE, from_north=True),
    Radar3D((100.0, -50.0, 20.0), 20.0, ANGLE, 2 * ANGLE),
    Radar3D((100.0, -50.0, 20.0), 20.0, ANGLE, 2 * ANGLE, from_north=True),
    PositionSensor(((4.0, 1.0), (1.0, 9.0))),
    PositionSensor(tuple(map(tuple, np.diag([4.0, 9.0, 16.0])))),
]


def positions(sensor, n=15):
    rng = np.random.default_rng(3)
    return rng.uniform(2e3, 2e4, (n, sensor.dim)) * np.where(
        rng.random((n, sensor.dim)) < 0.5, -1, 1
    )


@pytest.mark.parametrize("sensor", SENSORS, ids=repr)
def test_report_and_position_are_inverse(sensor):
    x = positions(sensor)
    np.testing.assert_allclose(
        sensor.to_cartesian(sensor.to_report(x), unbiased=False), x, rtol=1e-10
    )


@pytest.mark.parametrize("sensor", SENSORS, ids=repr)
def test_sensitivity_is_the_derivative_by_the_bias(sensor):
    # report = truth + bias: adding a bias to the report moves the converted position by B b
    x = positions(sensor)
    report = sensor.to_report(x)
    B = sensor.sensitivity(x)
    for k, unit in enumerate(sensor.bias_units):
        step = 1e-3 if unit == "m" else 1e-7
        bias = step * np.eye(len(sensor.bias_names))[k]
        ahead = sensor.to_cartesian(report + bias, unbiased=False)
        behind = sensor.to_cartesian(report - bias, unbiased=False)
        np.testing.assert_allclose((ahead - behind) / (2 * step), B[..., k], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("sensor", SENSORS, ids=repr)
def test_covariance_and_unbiasedness_by_simulation(sensor):
    # up to 9 covariances at 5 standard errors, 3 means at 5: false alarm rate below 1e-5
    x = positions(sensor, 1)
    rng = np.random.default_rng(4)
    noise = sensor.sample_noise(rng, 200_000)
    y = sensor.to_cartesian(sensor.to_report(x) + noise)
    error = y.std(axis=0) / np.sqrt(len(y))
    assert (np.abs(y.mean(axis=0) - x[0]) < 5.0 * error).all()
    expected, got = sensor.covariance(x)[0], np.cov(y.T)
    spread = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert (np.abs(got - expected) / spread < 5.0 * np.sqrt(2 / len(y)) + 1e-3).all()


def test_a_bias_from_north_is_counted_clockwise():
    radar = Radar2D((0.0, 0.0), 20.0, ANGLE, from_north=True)
    report = radar.to_report(np.array([[0.0, 1e4]]))
    np.testing.assert_allclose(report, [[1e4, 0.0]], atol=1e-9)
    moved = radar.to_cartesian(report + np.array([0.0, 0.01]), unbiased=False)
    assert moved[0, 0] > 0.0  # clockwise from north is towards east


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Radar2D((0.0, 0.0), 20.0, 5.0), "looks like degrees"),
        (lambda: Radar3D((0.0, 0.0, 0.0), 20.0, ANGLE, 4.0), "looks like degrees"),
        (lambda: Radar2D((0.0, 0.0), 0.0, ANGLE), "sigma_range"),
        (lambda: Radar2D((0.0, 0.0), 20.0, -ANGLE), "sigma_azimuth"),
        (lambda: Radar2D((0.0, np.nan), 20.0, ANGLE), "position of sensor 'radar'"),
        (lambda: Radar3D((0.0, 0.0), 20.0, ANGLE, ANGLE), "position of sensor 'radar'"),
        (lambda: PositionSensor(((1.0, 2.0), (2.0, 1.0))), "not positive definite"),
        (lambda: PositionSensor(((1.0,),)), "2 x 2 or 3 x 3"),
        (lambda: Radar2D((0.0, 0.0), None, ANGLE), "a number is needed"),
    ],
)
def test_impossible_sensors_are_refused(make, message):
    with pytest.raises(InvalidInputError, match=message):
        make()


def test_a_coarse_angle_is_questioned():
    with pytest.warns(UserWarning, match="were degrees meant"):
        Radar2D((0.0, 0.0), 20.0, 0.5)


def test_reports_in_degrees_are_recognised_and_outliers_are_not():
    radar = Radar3D((0.0, 0.0, 0.0), 20.0, ANGLE, ANGLE)
    reports = radar.to_report(positions(radar, 40))
    degrees = reports.copy()
    degrees[:, 1] = np.rad2deg(degrees[:, 1])
    with pytest.raises(InvalidInputError, match=r"azimuth of sensor 'radar'.*degrees"):
        radar.check(degrees)
    reports[3, 2] = 2.9  # one wild elevation is an outlier, not a unit
    np.testing.assert_array_equal(radar.check(reports), reports)


def test_a_target_above_the_radar_is_refused():
    radar = Radar3D((10.0, 20.0, 0.0), 20.0, ANGLE, ANGLE)
    with pytest.raises(InvalidInputError, match="row 0 lies on the vertical of sensor 'radar'"):
        radar.sensitivity(np.array([[10.0, 20.0, 5000.0]]))
