from __future__ import annotations

import numpy as np
import pytest

from probreg import AssociatedReports, BearingReports, BearingSensor
from probreg.errors import InvalidInputError
from probreg.sensors.reports import SensorReports, smoothed_positions
from tests.conftest import PAIR_BIAS, polar_reports, radar_pair


def rebuilt(data, **changes):
    fields = {
        "sensors": data.sensors,
        "values": data.values,
        "time": data.time,
        "tracks": data.tracks,
    }
    return AssociatedReports(**{**fields, **changes})


@pytest.fixture
def data():
    return polar_reports(radar_pair(), PAIR_BIAS, seed=1, n=30)


def spoil(values, row, column, with_):
    values = [v.copy() for v in values]
    values[1][row, column] = with_
    return tuple(values)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_non_finite_reports_are_located(data, bad):
    with pytest.raises(InvalidInputError, match=r"reports of sensor 'j'\[7, 2\] is (nan|inf)"):
        rebuilt(data, values=spoil(data.values, 7, 2, bad))


def test_shapes_must_agree(data):
    with pytest.raises(InvalidInputError, match="differ in number: {'i': 30, 'j': 29}"):
        rebuilt(data, values=(data.values[0], data.values[1][:-1]))
    with pytest.raises(InvalidInputError, match=r"shape \(30, 2\)"):
        rebuilt(data, values=(data.values[0], data.values[1][:, :2]))
    with pytest.raises(InvalidInputError, match="1 report arrays for 2 sensors"):
        rebuilt(data, values=data.values[:1])
    with pytest.raises(InvalidInputError, match="time has shape"):
        rebuilt(data, time=data.time[:3])
    with pytest.raises(InvalidInputError, match="tracks has shape"):
        rebuilt(data, tracks=np.zeros((30, 3), dtype=int))


def test_one_sensor_is_not_enough(data):
    with pytest.raises(InvalidInputError, match="at least two sensors"):
        rebuilt(data, sensors=data.sensors[:1], values=data.values[:1])


def test_sensor_names_must_differ(data):
    with pytest.raises(InvalidInputError, match="repeat"):
        rebuilt(data, sensors=radar_pair(("a", "a")))


def test_sensors_of_a_row_must_have_one_dimension(data, flat_pair):
    with pytest.raises(InvalidInputError, match="different dimension"):
        AssociatedReports((data.sensors[0], flat_pair[1]), (data.values[0], data.values[1][:, :2]))


def test_running_median_follows_the_track_and_ignores_outliers_and_pairing():
    sensors = radar_pair()
    time = np.repeat(np.arange(60.0), 2)
    own = np.tile([0, 1], 60)
    partner = own.copy()
    partner[40:44] = partner[40:44][::-1]  # two scans with exchanged reports
    start = np.array([[8e3, 9e3, 3e3], [-9e3, 7e3, 2e3]])
    truth = start[:, None] + time.reshape(60, 2).T[..., None] * np.array([30.0, -20.0, 0.0])
    scan = time.astype(int)
    values = tuple(
        s.to_report(truth[track, scan]) for s, track in zip(sensors, (own, partner), strict=True)
    )
    values[0][10] += [5000.0, 0.3, 0.2]
    data = AssociatedReports(sensors, values, time, np.column_stack([own, partner]))
    smooth = smoothed_positions(data, window=5)
    inside = (scan > 2) & (scan < 57)
    for got, track in zip(smooth, (own, partner), strict=True):
        np.testing.assert_allclose(got[inside], truth[track, scan][inside], atol=40.0)
    assert np.abs(data.positions()[0][10] - truth[own[10], scan[10]]).max() > 1000.0


def test_smoothing_needs_tracks_and_an_odd_window(data):
    with pytest.raises(InvalidInputError, match="track number"):
        smoothed_positions(data)
    tracked = rebuilt(data, tracks=np.zeros((30, 2), dtype=int))
    with pytest.raises(InvalidInputError, match="odd"):
        smoothed_positions(tracked, window=4)


def test_reports_that_place_no_target_cannot_be_compared_as_positions(flat_pair):
    camera = BearingSensor(2e-3, "camera")
    values = (np.array([[1e4, 0.1]]), np.array([[0.2]]))
    for make in (
        lambda: AssociatedReports((flat_pair[0], camera), values),
        lambda: SensorReports(camera, values[1]),
    ):
        with pytest.raises(InvalidInputError, match=r"'camera' \(bearing\) places no target"):
            make()


def test_bearings_come_as_numbers_or_as_a_column():
    sensor, own = BearingSensor(2e-3), np.zeros((3, 2))
    bearing = sensor.to_report(np.array([[1.0, 2.0], [3.0, -4.0], [-5.0, 1.0]]), own)
    assert bearing.shape == (3, 1)
    one, two = (BearingReports(sensor, b, own) for b in (bearing, bearing[:, 0]))
    np.testing.assert_array_equal(one.bearing, two.bearing)
    assert one.bearing.shape == (3,)
    for wrong in (np.tile(bearing, 2), bearing[None]):
        with pytest.raises(InvalidInputError, match="bearing of sensor 'sensor' has shape"):
            BearingReports(sensor, wrong, own)
