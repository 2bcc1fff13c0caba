"""Radars with local trackers, from files to remarks: noise is Cartesian, biases are polar."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import PositionSensor, Tracker2D, recordings
from probreg.errors import InvalidInputError
from probreg.recordings import new_table, setup_file
from probreg.registration import LAWS, register
from tests.registration.conftest import fly, vector

THETA = {"a.range": 300.0, "a.azimuth": 8e-3, "b.range": -200.0, "b.azimuth": -5e-3}
SIGMA = 40.0


def trackers(sigma=SIGMA):
    return (
        Tracker2D((0.0, 0.0), sigma, "a"),
        Tracker2D((30e3, 5e3), SIGMA, "b", from_north=True),
        PositionSensor.independent((20.0, 30.0), "c"),
    )


def test_noise_without_a_place_is_refused():
    with pytest.raises(InvalidInputError, match="pass `at`"):
        trackers()[0].sample_noise(np.random.default_rng(0), 3)


@pytest.mark.parametrize("factor", [1.0, 4.0], ids=["as declared", "four times declared"])
def test_registered_from_files_and_judged_in_metres(tmp_path, factor):
    made = fly(trackers(), THETA, targets=60, scans=12)
    recording = dataclasses.replace(made.recording, labels=tuple(map(str, range(60))))
    declared = dataclasses.replace(made.setup, sensors=trackers(SIGMA / factor))
    setup_file.write(tmp_path / "sensors.toml", declared)
    new_table.create(tmp_path / "r.csv", recording, declared)
    setup = setup_file.read(tmp_path / "sensors.toml")
    assert setup.sensors == declared.sensors
    read = recordings.read(tmp_path / "r.csv", setup).recording
    found = register(read, setup, rng=np.random.default_rng(1), laws=LAWS[:1], num_draws=400)
    said = " ".join(found.notes)
    if factor == 1.0:
        # 4 biases at 4.5 posterior sd: false alarm about 1e-4 with some tail
        assert (np.abs(found.mean - vector(made, found.names)) < 4.5 * found.sd).all()
        assert "spread" not in said
    else:
        assert "a: range spread" in said
        assert "set sigma_m near" in said
