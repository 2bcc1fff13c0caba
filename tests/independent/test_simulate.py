"""The simulator: exact reports meet at the true place, and every error enters as it is said to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pyproj import Transformer
from scipy import stats

from tests.independent import rays
from tests.independent.cases import CASES, all_terms, easy, no_heights, radar3d
from tests.independent.earth import look
from tests.independent.scene import FOOT_M, Barometer, PositionReports, Scene
from tests.independent.simulate import simulate

GEOCENTRIC = Transformer.from_crs(4979, 4978)


def exact(scene: Scene, **changes) -> Scene:
    """Without noise, biases and refraction; every radar measures elevation."""
    radars = tuple(
        replace(r, unknown={}, refraction=False, sigma_elevation_deg=0.1) for r in scene.radars
    )
    plain = replace(scene, radars=radars, positions=PositionReports(), noise=0.0, fixed={})
    return replace(plain, **{"barometer": Barometer(), "duration_s": 120.0, **changes})


def own_frame(radar):
    """Topocentric pipeline of a radar, from its own coordinates back to the earth's centre."""
    return Transformer.from_pipeline(
        f"+proj=topocentric +ellps=WGS84 +lat_0={radar.latitude_deg} "
        f"+lon_0={radar.longitude_deg} +h_0={radar.height_m}"
    )


def centred(radar, distance, azimuth_deg, elevation):
    """Earth-centred coordinates (n, 3) of reports, by pyproj."""
    azimuth, level = np.deg2rad(azimuth_deg), distance * np.cos(elevation)
    local = (level * np.sin(azimuth), level * np.cos(azimuth), distance * np.sin(elevation))
    return np.stack(own_frame(radar).transform(*local, direction="INVERSE"), axis=-1)


def rows_of(simulated, sensor):
    return np.flatnonzero(simulated.reports["sensor"] == sensor.name)


def true_places(simulated, rows):
    return np.stack(GEOCENTRIC.transform(*simulated.truth.places[rows].T), axis=-1)


@pytest.mark.parametrize("name", ["easy", "near", "wide"])
def test_exact_reports_of_every_sensor_meet_at_the_true_place(name):
    simulated = simulate(exact(CASES[name]()), np.random.default_rng(1))
    reports = simulated.reports
    for radar in simulated.scene.radars:
        rows = rows_of(simulated, radar)
        assert len(rows) > 100
        polar = (reports[name][rows] for name in ("range_m", "azimuth_deg"))
        found = centred(radar, *polar, np.deg2rad(reports["elevation_deg"][rows]))
        assert np.abs(found - true_places(simulated, rows)).max() < 1e-3
    rows = rows_of(simulated, simulated.scene.positions)
    columns = ("latitude_deg", "longitude_deg", "height_m")
    found = np.stack(GEOCENTRIC.transform(*(reports[name][rows] for name in columns)), axis=-1)
    assert np.abs(found - true_places(simulated, rows)).max() < 1e-3


def test_slant_range_azimuth_and_height_alone_meet_there_too():
    simulated = simulate(exact(CASES["wide"]()), np.random.default_rng(2))
    radar = simulated.scene.radars[0]
    rows = rows_of(simulated, radar)
    distance, azimuth = (simulated.reports[name][rows] for name in ("range_m", "azimuth_deg"))
    height = simulated.reports["pressure_altitude_m"][rows]
    low, high = np.full(len(rows), -0.1), np.full(len(rows), 0.5 * np.pi)
    for _ in range(60):
        middle = 0.5 * (low + high)
        x = centred(radar, distance, azimuth, middle)
        above = GEOCENTRIC.transform(*x.T, direction="INVERSE")[2] > height
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    assert np.abs(x - true_places(simulated, rows)).max() < 1e-3


def test_truth_is_where_the_flights_are():
    simulated = simulate(exact(easy()), np.random.default_rng(3))
    truth = simulated.truth
    flown = truth.flights.at(truth.aircraft, truth.time)
    np.testing.assert_allclose(np.deg2rad(truth.places[:, :2]), flown[:, :2], atol=1e-14)
    assert (np.diff(simulated.reports["time_s"]) >= 0.0).all()


def test_every_term_enters_as_it_is_said_to():
    scene = exact(all_terms(), positions=PositionReports(unknown={"time": 0.5}))
    fixed = {"barometer.height": 120.0, "barometer.height_gain": -0.01}
    for k, radar in enumerate(scene.radars, start=1):
        for term, value in (
            *(("range", 40.0), ("range_gain", 4e-4), ("azimuth", 0.2), ("elevation", -0.1)),
            *(("azimuth_sine", 0.05), ("azimuth_cosine", -0.03), ("time", 0.1)),
        ):
            fixed[f"{radar.name}.{term}"] = k * value
    scene = replace(scene, fixed=fixed, delay_sd_m=20.0)
    simulated = simulate(scene, np.random.default_rng(4))
    reports, truth = simulated.reports, simulated.truth
    for k, radar in enumerate(scene.radars, start=1):
        rows = rows_of(simulated, radar)
        places = truth.places[rows] * [np.pi / 180.0, np.pi / 180.0, 1.0]
        distance, azimuth, elevation = look(radar.place, places).T
        delay = truth.delay_m[truth.aircraft[rows]]
        more = reports["range_m"][rows] - distance
        np.testing.assert_allclose(more, delay + k * (40.0 + 4e-4 * distance), atol=1e-6)
        more = reports["azimuth_deg"][rows] - np.rad2deg(azimuth)
        wave = 0.2 + 0.05 * np.sin(azimuth) - 0.03 * np.cos(azimuth)
        np.testing.assert_allclose((more + 180.0) % 360.0 - 180.0, k * wave, atol=1e-9)
        more = reports["elevation_deg"][rows] - np.rad2deg(elevation)
        np.testing.assert_allclose(more, -0.1 * k, atol=1e-9)
        np.testing.assert_allclose(reports["time_s"][rows] - truth.time[rows], 0.1 * k, atol=1e-9)
    heights = truth.places[:, 2]
    error = reports["pressure_altitude_m"] - heights
    np.testing.assert_allclose(error, 120.0 - 0.01 * heights, atol=1e-6)


def test_late_positions_are_stamped_after_they_were_true():
    simulated = simulate(replace(CASES["late_adsb"](), noise=0.0), np.random.default_rng(5))
    rows = rows_of(simulated, simulated.scene.positions)
    stamp, truth = simulated.reports["time_s"][rows], simulated.truth
    np.testing.assert_allclose(stamp - truth.time[rows], 0.6, atol=1e-9)
    old = truth.flights.at(truth.aircraft[rows], stamp - 0.6)
    found = simulated.reports["latitude_deg"][rows]
    np.testing.assert_allclose(found, np.rad2deg(old[:, 0]), atol=1e-9)
    assert np.abs(found - np.rad2deg(truth.flights.at(truth.aircraft[rows], stamp)[:, 0])).max() > (
        1e-5
    )


def test_refraction_is_that_of_rays_to_the_same_places():
    scene = replace(exact(radar3d()), refraction_scale=1.1)
    scene = replace(scene, radars=tuple(replace(r, refraction=True) for r in scene.radars))
    simulated = simulate(scene, np.random.default_rng(6))
    radar = scene.radars[1]
    rows = rows_of(simulated, radar)[:40]
    apparent = np.deg2rad(simulated.reports["elevation_deg"][rows])
    places = simulated.truth.places[rows] * [np.pi / 180.0, np.pi / 180.0, 1.0]
    distance, _, elevation = look(radar.place, places).T
    # the ray that leaves at the reported elevation passes through the place
    traced = rays.trace(apparent, radar.height_m, 100.0, 2600, 1.1)
    for k in range(len(rows)):
        there = np.interp(distance[k], traced.chord[:, k], traced.elevation[:, k])
        assert there == pytest.approx(elevation[k], abs=3e-7)
        late = np.interp(distance[k], traced.chord[:, k], traced.excess[:, k])
        reported = simulated.reports["range_m"][rows[k]]
        assert reported - distance[k] == pytest.approx(late, abs=3e-3)
    assert (apparent - elevation).max() > 1e-3


def test_an_antenna_turns_once_a_scan():
    simulated = simulate(exact(easy()), np.random.default_rng(7))
    starts = []
    for radar in simulated.scene.radars:
        rows = rows_of(simulated, radar)
        turned = simulated.truth.time[rows] / radar.scan_s
        ahead = 2.0 * np.pi * (turned - simulated.reports["azimuth_deg"][rows] / 360.0)
        assert np.abs(np.angle(np.exp(1j * (ahead - ahead[0])))).max() < 1e-4
        starts.append(ahead[0])
    # each has a phase of its own
    assert np.abs(np.angle(np.exp(1j * np.diff(starts)))).min() > 1e-2


# each count is judged by exact binomial limits at 1e-6
def within(count, number, share):
    low, high = stats.binom.interval(1.0 - 1e-6, number, share)
    return low <= count <= high


def test_noise_outliers_identities_detections_and_heights_are_as_declared():
    scene = replace(
        easy(),
        outliers=0.05,
        wrong=0.1,
        detection=0.8,
        barometer=Barometer(reported=0.7, sigma_m=0.0),
        radars=tuple(replace(r, refraction=False, unknown={}) for r in easy().radars),
    )
    simulated = simulate(scene, np.random.default_rng(8))
    truth, reports = simulated.truth, simulated.reports
    n = len(truth.time)
    assert within(truth.outlier.sum(), n, 0.05)
    assert within(truth.wrong.sum(), n, 0.1)
    mistaken = np.array([int(one, 16) - 0x3C0000 for one in reports["target"]]) != truth.aircraft
    np.testing.assert_array_equal(mistaken, truth.wrong)
    heights = reports["pressure_altitude_m"]
    assert within(np.isfinite(heights).sum(), n, 0.7)
    feet = heights[np.isfinite(heights)] / FOOT_M
    np.testing.assert_allclose(feet, 25.0 * np.rint(feet / 25.0), atol=1e-6)
    assert 0.2 < np.mean(np.abs(feet - 100.0 * np.rint(feet / 100.0)) > 1.0) < 0.6
    for radar in scene.radars:
        rows = rows_of(simulated, radar)
        places = truth.places[rows] * [np.pi / 180.0, np.pi / 180.0, 1.0]
        noise = (reports["range_m"][rows] - look(radar.place, places)[:, 0]) / radar.sigma_range_m
        for odd, sd in ((False, 1.0), (True, 10.0)):
            own = noise[truth.outlier[rows] == odd] / sd
            # mean and variance at 5 standard errors each
            assert abs(own.mean()) < 5.0 / np.sqrt(len(own))
            assert abs(np.mean(own**2) - 1.0) < 5.0 * np.sqrt(2.0 / len(own))
    seen_always = simulate(replace(scene, detection=1.0), np.random.default_rng(8))
    radar = scene.radars[0]
    share = len(rows_of(simulated, radar)) / len(rows_of(seen_always, radar))
    assert share == pytest.approx(0.8, abs=0.03)


@pytest.mark.parametrize("name", CASES)
def test_every_case_gives_a_recording_by_its_seed_alone(name):
    scene = replace(CASES[name](), duration_s=60.0)
    one, same, other = (simulate(scene, np.random.default_rng(seed)) for seed in (1, 1, 2))
    for column, values in one.reports.items():
        np.testing.assert_array_equal(values, same.reports[column])
    assert len(other.reports["time_s"]) != len(values) or (other.reports["time_s"] != values).any()
    found = set(one.reports["sensor"])
    assert found == {sensor.name for sensor in scene.sensors}


def test_where_no_height_is_reported_there_is_none():
    simulated = simulate(replace(no_heights(2), duration_s=60.0), np.random.default_rng(1))
    for name in ("height_m", "pressure_altitude_m", "elevation_deg"):
        assert np.isnan(simulated.reports[name]).all()
