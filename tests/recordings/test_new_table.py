"""A new table is read as the recording it was made of, with all it can hold."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from probreg.recordings import Recording, Setup, new_table, table
from probreg.sensors import BearingSensor, PositionSensor, Radar2D
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
    setup = Setup(sensors, {}, body_frame=frozenset({"camera"}), origin=origin)
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


def test_with_an_origin_the_cells_count_from_true_north_at_the_radar(tmp_path):
    sensors = (Radar2D((90e3, 1e4), 5.0, 0.01, "a", from_north=True),)
    time, target = np.zeros(1), np.array([-1])
    recording = Recording(sensors, np.zeros(1, int), time, np.array([[5e4, 0.5]]), target)
    setup = Setup(sensors, {}, origin=(60.0, 8.0, 0.0))
    new_table.create(tmp_path / "r.csv", recording, setup)
    cell = pd.read_csv(tmp_path / "r.csv")["azimuth_deg"][0]
    turn = np.rad2deg(LocalFrame(60.0, 8.0, 0.0).convergence(np.array([90e3, 1e4])))
    np.testing.assert_allclose(cell, np.rad2deg(0.5) - turn, atol=1e-10)
    assert abs(turn) > 1.0
