"""A new table is read as the recording it was made of, with all it can hold."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from probreg.recordings import Recording, Setup, new_table, table
from probreg.sensors import Barometer, BearingSensor, PositionSensor, Radar2D
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle


@pytest.mark.parametrize("origin", [None, (60.0, 8.0, 0.0)])
@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_every_column_goes_out_and_comes_in(tmp_path, kind, origin):
    rng = np.random.default_rng(0)
    sensors = (
        Radar2D((90e3, 1e4), 5.0, 0.01, "radar", from_north=True),
        BearingSensor(0.01, "camera"),
        PositionSensor(((1.0, 0.0), (0.0, 1.0)), "gnss"),
    )
    sensor = np.arange(90) % 3
    values = np.column_stack([rng.uniform(-3, 3, 90), rng.uniform(-3, 3, 90)])
    values[sensor == 0, 0] += 500.0
    values[sensor == 1, 1] = np.nan
    own = np.where(sensor[:, None] < 2, rng.normal(size=(90, 2)), 0.0)
    heading = rng.uniform(-3, 3, 90)
    target = rng.integers(-1, 2, 90)
    time = np.sort(rng.uniform(0, 9, 90))
    recording = Recording(sensors, sensor, time, values, target, ("p", "q"), own, heading)
    setup = Setup(sensors, {}, body_frame=frozenset({"camera"}), origin=origin, targets="surface")
    new_table.create(tmp_path / f"r.{kind}", recording, setup)
    again = table.read(tmp_path / f"r.{kind}", setup).recording
    np.testing.assert_array_equal(again.sensor, sensor)
    np.testing.assert_allclose(again.time, time, rtol=1e-14)
    difference = again.values - values
    difference[sensor < 2] = wrap_angle(difference[sensor < 2])
    np.testing.assert_array_equal(np.isnan(difference), np.isnan(values))
    assert np.nanmax(np.abs(difference)) < 1e-12
    np.testing.assert_allclose(again.own_position, own, rtol=1e-14)
    np.testing.assert_allclose(wrap_angle(again.heading - heading), 0.0, atol=1e-12)
    labels = np.array(["p", "q", ""])
    found = np.array([*again.labels, ""])
    np.testing.assert_array_equal(found[again.target], labels[target])


def test_with_an_origin_headings_count_from_true_north_and_azimuths_stay(tmp_path):
    sensors = (Radar2D((90e3, 1e4), 5.0, 0.01, "a", from_north=True),)
    time, target = np.zeros(1), np.array([-1])
    values, own, heading = np.array([[5e4, 0.5]]), np.array([[0.0, 1e3]]), np.array([1.0])
    recording = Recording(
        sensors, np.zeros(1, int), time, values, target, own_position=own, heading=heading
    )
    setup = Setup(sensors, {}, origin=(60.0, 8.0, 0.0))
    new_table.create(tmp_path / "r.csv", recording, setup)
    cells = pd.read_csv(tmp_path / "r.csv")
    np.testing.assert_allclose(cells["azimuth_deg"][0], np.rad2deg(0.5), atol=1e-10)
    turn = np.rad2deg(LocalFrame(60.0, 8.0, 0.0).convergence(np.array([90e3, 1.1e4])))
    compass = 90.0 - np.rad2deg(1.0) - turn
    np.testing.assert_allclose(cells["heading_deg"][0], compass, atol=1e-10)
    assert abs(turn) > 1.0


def test_reports_beside_others_stand_in_their_rows(tmp_path):
    radar = Radar2D((0.0, 0.0), 5.0, 0.01, "a", from_north=True)
    sensors = (radar, dataclasses.replace(radar, name="b"), Barometer(10.0))
    values = np.array([[5e4, 0.5], [9e3, np.nan], [6e4, 0.6], [8e3, np.nan]])
    recording = Recording(
        sensors,
        np.array([0, 2, 1, 2]),
        np.array([0.0, 0.0, 1.0, 2.0]),
        values,
        np.zeros(4, int),
        ("p",),
        beside=np.array([0, 0, 2, 3]),
    )
    setup = Setup(sensors, {})
    new_table.create(tmp_path / "r.csv", recording, setup)
    cells = pd.read_csv(tmp_path / "r.csv")
    assert list(cells["sensor"]) == ["a", "b", "barometer"]
    np.testing.assert_array_equal(cells["pressure_altitude_m"], [9e3, np.nan, 8e3])
    again = table.read(tmp_path / "r.csv", setup).recording
    np.testing.assert_allclose(again.values, values[[0, 1, 2, 3]], rtol=1e-14)
    np.testing.assert_array_equal(again.beside, recording.beside)
