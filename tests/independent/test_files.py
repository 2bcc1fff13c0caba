"""What the simulator writes is what the package reads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from probreg.recordings import setup_file, table
from tests.independent.cases import CASES
from tests.independent.files import write
from tests.independent.simulate import simulate


@pytest.mark.parametrize("name", ["no_reference", "late_adsb"])
def test_a_recording_is_read_as_it_was_simulated(tmp_path, name):
    simulated = simulate(replace(CASES[name](), duration_s=60.0), np.random.default_rng(1))
    write(simulated, tmp_path)
    setup = setup_file.read(tmp_path / "sensors.toml")
    scene = simulated.scene
    assert setup.origin == (*scene.centre_deg, 0.0)
    for sensor in (*scene.sensors, scene.barometer):
        assert setup.biases[sensor.name] == tuple(sensor.unknown)
    assert set(setup.refraction.values()) == {"standard"}
    assert setup.prior_sd["north.azimuth"] == pytest.approx(np.deg2rad(0.3))
    found = table.read(tmp_path / "reports.csv", setup).recording
    alone = np.flatnonzero(found.alone)
    np.testing.assert_array_equal(found.time[alone], simulated.reports["time_s"])
    radars = np.isfinite(simulated.reports["range_m"])
    ranges = found.values[alone][radars, 0]
    np.testing.assert_array_equal(ranges, simulated.reports["range_m"][radars])
    heights = found.values[~found.alone, 0]
    beside = found.beside[~found.alone]
    wanted = simulated.reports["pressure_altitude_m"][np.searchsorted(alone, beside)]
    np.testing.assert_array_equal(heights, wanted)
    labels = np.array(found.labels)[found.target[alone]]
    np.testing.assert_array_equal(labels, simulated.reports["target"].astype(str))


def test_a_wrong_model_can_be_asked_for_and_empty_columns_are_left_out(tmp_path):
    simulated = simulate(
        replace(CASES["no_heights_2"](), duration_s=60.0), np.random.default_rng(1)
    )
    write(simulated, tmp_path, asked={"north": ("range",), "targets": ("range", "time")})
    setup = setup_file.read(tmp_path / "sensors.toml")
    assert setup.biases["north"] == ("range",)
    assert setup.target_terms == {"range": 20.0, "time": 20.0}
    header = (tmp_path / "reports.csv").read_text().splitlines()[0]
    assert header == "time_s,sensor,target,range_m,azimuth_deg"
