"""The package's frame, placements, refraction and heights give the simulator's exact reports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import azimuth_from_north, wrap_angle
from probreg.sensors.refraction import refraction
from tests.independent.cases import wide
from tests.independent.scene import Barometer, PositionReports
from tests.independent.simulate import simulate


@pytest.fixture(scope="module")
def recorded():
    """No noise and no bias, refraction as rays have it, elevation from every radar."""
    scene = wide()
    radars = tuple(replace(r, unknown={}, sigma_elevation_deg=0.1) for r in scene.radars)
    scene = replace(
        scene,
        radars=radars,
        positions=PositionReports(),
        barometer=Barometer(),
        noise=0.0,
        duration_s=120.0,
    )
    return simulate(scene, np.random.default_rng(1))


@pytest.fixture(scope="module")
def frame(recorded):
    return LocalFrame(*recorded.scene.centre_deg, 0.0)


@pytest.mark.parametrize("sensor", range(4))
def test_reports_of_radars(recorded, frame, sensor):
    radar, reports = recorded.scene.radars[sensor], recorded.reports
    rows = np.flatnonzero(reports["sensor"] == radar.name)
    place = np.array([radar.latitude_deg, radar.longitude_deg, radar.height_m])
    polar = frame.placement(place).polar(frame.from_geodetic(recorded.truth.places[rows]))
    distance, azimuth, elevation = polar.T
    added = refraction(distance, elevation, radar.height_m)
    late = distance + added.range - reports["range_m"][rows]
    bent = elevation + added.elevation - np.deg2rad(reports["elevation_deg"][rows])
    # a target that is low and far is beyond what the chord can do: 2 % of its refraction
    assert (np.abs(late) < 0.01 + 0.02 * added.range).all()
    assert (np.abs(bent) < 1e-6 + 0.025 * added.elevation).all()
    near = distance < 100e3
    assert np.abs(late[near]).max() < 0.1
    assert np.abs(bent[near]).max() < 1.1e-5
    turn = wrap_angle(azimuth_from_north(azimuth) - np.deg2rad(reports["azimuth_deg"][rows]))
    assert np.abs(turn).max() < 1e-9
    assert added.range.max() > 20.0


def test_reports_of_heights_and_positions(recorded, frame):
    x = frame.from_geodetic(recorded.truth.places)
    height, _ = frame.height(x)
    np.testing.assert_allclose(height, recorded.reports["pressure_altitude_m"], atol=1e-6)
    rows = np.flatnonzero(recorded.reports["sensor"] == "adsb")
    columns = ("latitude_deg", "longitude_deg", "height_m")
    places = np.stack([recorded.reports[name][rows] for name in columns], axis=1)
    np.testing.assert_allclose(frame.from_geodetic(places), x[rows], atol=1e-6)
