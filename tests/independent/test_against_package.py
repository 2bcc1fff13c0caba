"""The package reads, and sees, the simulator's exact reports: every case, every sensor."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from probreg.recordings import (
    Reading,
    bias_model,
    corrected_values,
    observing_axes,
    places,
    setup_file,
    table,
)
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle
from tests.independent.cases import CASES
from tests.independent.files import write
from tests.independent.simulate import Simulated, simulate

# what first-order refraction leaves: standard deviations of the scenes' radars
LEFT = {"range": 0.025, "azimuth": 1e-4, "elevation": 0.05, "height": 1e-4}


class Case(NamedTuple):
    """A recording without noise, as the package reads it, and where the targets were."""

    simulated: Simulated
    reading: Reading
    values: np.ndarray
    time: np.ndarray
    x: np.ndarray


@pytest.fixture(scope="module", params=CASES)
def case(request, tmp_path_factory):
    """Every scene, its biases taken out by the package itself and delays by the simulator's."""
    scene = replace(CASES[request.param](), duration_s=120.0, noise=0.0)
    simulated = simulate(scene, np.random.default_rng(1))
    folder = tmp_path_factory.mktemp(request.param)
    write(simulated, folder)
    reading = table.read(folder / "reports.csv", setup_file.read(folder / "sensors.toml"))
    recording, setup = reading.recording, reading.setup
    names = bias_model(setup).names
    assert set(names) == set(simulated.truth.bias)
    theta = np.array([simulated.truth.bias[name] for name in names])
    values, time = corrected_values(recording, setup, theta)
    radars = np.isin(recording.sensor, range(len(scene.radars)))
    truth = simulated.truth
    values[radars, 0] -= truth.delay_m[truth.aircraft[reading.rows]][radars]
    x = LocalFrame(*setup.origin).from_geodetic(truth.places[reading.rows])
    return Case(simulated, reading, values, time, x)


def test_every_case_is_of_three_dimensions_and_complete(case):
    scene, setup = case.simulated.scene, case.reading.setup
    assert setup.dim == 3
    unknown = scene.positions is None and scene.barometer is None
    assert len(case.reading.notes) == unknown
    assert all("no report tells a height" in note for note in case.reading.notes)
    kinds = [sensor.kind.name for sensor in setup.sensors]
    assert ("barometer" in kinds) == (scene.barometer is not None)
    assert setup.target_terms == ({"range": scene.delay_sd_m} if scene.delay_sd_m else {})
    heights = np.isfinite(case.simulated.reports["pressure_altitude_m"]).sum()
    assert len(case.reading.recording) == len(case.simulated.reports["time_s"]) + heights
    np.testing.assert_allclose(case.time, case.simulated.truth.time[case.reading.rows], atol=1e-9)


def test_noise_free_reports_are_what_the_axes_see(case):
    recording, setup = case.reading.recording, case.reading.setup
    for k, (sensor, axes) in enumerate(zip(setup.sensors, observing_axes(setup), strict=True)):
        rows = np.flatnonzero(recording.sensor == k)
        seen = axes.observe(case.x[rows])
        off = case.values[rows, : len(sensor.bias_names)] - seen.value
        off[:, axes.angles] = wrap_angle(off[:, axes.angles])
        worst = np.nanmax(np.abs(off) / sensor.sigmas, axis=0)
        wanted = [LEFT.get(name, 1e-4) for name in sensor.bias_names]
        assert (worst < wanted).all(), (sensor.name, worst)
        assert np.isfinite(off).all()


def test_reports_are_placed_at_their_targets(case):
    recording, setup = case.reading.recording, case.reading.setup
    where = places(recording, setup, case.values)
    heights = [k for k, s in enumerate(setup.sensors) if s.kind.beside is not None]
    np.testing.assert_array_equal(np.isnan(where).all(axis=1), np.isin(recording.sensor, heights))
    away = np.linalg.norm(where - case.x, axis=1)
    # a sphere for the ellipsoid, and where no height is known a guess of it
    assert np.nanmax(away) < (30.0 if heights else 10e3)


@pytest.mark.parametrize("case", ["wide"], indirect=True)
def test_without_refraction_or_the_radars_own_level_they_would_not_be(case):
    """The control of the tests above."""
    recording, setup = case.reading.recording, case.reading.setup
    names = [s.name for s in setup.sensors]
    flat = replace(setup, places={})
    straight = replace(setup, refraction=dict.fromkeys(names[:4], "none"))
    for wrong, component in ((flat, 1), (straight, 0)):
        k = names.index("south")
        rows = np.flatnonzero(recording.sensor == k)
        seen = observing_axes(wrong)[k].observe(case.x[rows]).value[:, component]
        off = wrap_angle(case.values[rows, component] - seen)
        if component == 0:
            off = case.values[rows, 0] - seen
        assert np.abs(off / setup.sensors[k].sigmas[component]).max() > 0.3
