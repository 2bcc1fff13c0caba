"""A kind of sensor is one module: dropped into the package, every room of reading knows it."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from probreg import Radar2D, recordings
from probreg.recordings import Recording, Setup, new_table, observing_axes, setup_file
from probreg.sensors import kinds, known_kinds
from tests.conformance.sensor_facts import FACTS, made


@pytest.fixture
def ranging(tmp_path, monkeypatch):
    shutil.copy(Path(__file__).with_name("ranging_kind.py"), tmp_path / "ranging.py")
    monkeypatch.setattr(kinds, "__path__", [*kinds.__path__, str(tmp_path)])
    known_kinds.cache_clear()
    yield known_kinds()["ranging"]
    sys.modules.pop(f"{kinds.__name__}.ranging")
    vars(kinds).pop("ranging")
    known_kinds.cache_clear()


def test_it_conforms(ranging):
    for fact in FACTS:
        fact(made("ranging"))


def test_files_know_it_and_its_axes_see_what_it_reports(ranging, tmp_path):
    sensors = (
        Radar2D((0.0, 0.0), 20.0, 2e-3, "a"),
        Radar2D((30e3, 5e3), 30.0, 3e-3, "b", from_north=True),
        ranging((-10e3, 20e3), 10.0, "new"),
    )
    x = np.random.default_rng(0).uniform(-40e3, 40e3, (60, 2))
    sensor = np.arange(60) % 3
    values = np.full((60, 2), np.nan)
    for k, one in enumerate(sensors):
        q = len(one.bias_names)
        values[sensor == k, :q] = one.to_report(x[sensor == k])
    labels = tuple("abcdefghijklmnopqrst")
    recording = Recording(sensors, sensor, np.arange(60.0), values, np.arange(60) // 3, labels)
    setup_file.write(
        tmp_path / "sensors.toml", Setup(sensors, {s.name: ("range",) for s in sensors})
    )
    setup = setup_file.read(tmp_path / "sensors.toml")
    assert setup.sensors == sensors
    new_table.create(tmp_path / "r.csv", recording, setup)
    read = recordings.read(tmp_path / "r.csv", setup).recording
    np.testing.assert_allclose(read.values[:, 0], values[:, 0], rtol=1e-12)
    axes = observing_axes(setup)[2]
    np.testing.assert_allclose(axes.observe(x[sensor == 2]).value, read.values[sensor == 2, :1])
    where = recordings.places(read, setup, read.values)
    np.testing.assert_allclose(where[sensor < 2], x[sensor < 2], atol=1e-6)
    assert np.isnan(where[sensor == 2]).all()
