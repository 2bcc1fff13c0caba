"""Reports of a scene: each sensor's own earth-centred geometry, ray-traced refraction, errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tests.independent import rays
from tests.independent.earth import displaced, look
from tests.independent.flights import Flights
from tests.independent.looks import draw_flights, positions_seen, radar_sees
from tests.independent.scene import FOOT_M, PositionReports, Radar, Scene

TERMS = ("range", "range_gain", "azimuth", "azimuth_sine", "azimuth_cosine", "elevation")
COLUMNS = ("range_m", "azimuth_deg", "elevation_deg", "latitude_deg", "longitude_deg", "height_m")


class Truth(NamedTuple):
    """What an estimator may not see; arrays are of the n reports.

    Attributes
    ----------
    bias : dict of str to float
        By name, SI units. Angles are clockwise from north; times are what a clock, or a late
        position, adds to the stamp.
    time : ndarray, shape (n,)
        When the aircraft was where the report has it.
    places : ndarray, shape (n, 3)
        Latitude and longitude in degrees, height.
    aircraft : ndarray of int, shape (n,)
        Which aircraft was seen; `target` of the reports may say another.
    outlier, wrong : ndarray of bool, shape (n,)
    delay_m : ndarray, shape (k,)
        Of each aircraft's transponder.
    flights : Flights
    """

    bias: dict[str, float]
    time: np.ndarray
    places: np.ndarray
    aircraft: np.ndarray
    outlier: np.ndarray
    wrong: np.ndarray
    delay_m: np.ndarray
    flights: Flights


class Simulated(NamedTuple):
    """Reports in the order of their stamps, the scene, and the truth.

    `reports` holds arrays (n,) by column: `time_s`, `sensor`, `target`, those of `COLUMNS` and
    `pressure_altitude_m`; NaN where a report has no such number.
    """

    reports: dict[str, np.ndarray]
    scene: Scene
    truth: Truth


def name_of(aircraft: np.ndarray) -> np.ndarray:
    """Identities of aircraft: 24-bit addresses."""
    return np.array([f"{0x3C0000 + int(k):06x}" for k in aircraft.ravel()], dtype=object)


def observe(
    radar: Radar,
    places: np.ndarray,
    bias: Mapping[str, float],
    delay_m: np.ndarray | float = 0.0,
    scale: float = 1.0,
) -> np.ndarray:
    """Range, azimuth and elevation (n, 3) without noise that a radar reports of places (n, 3)."""
    seen = look(radar.place, places)
    theta = {
        term: bias.get(f"{radar.name}.{term}", 0.0)
        for term in (
            "range",
            "range_gain",
            "azimuth",
            "azimuth_sine",
            "azimuth_cosine",
            "elevation",
        )
    }
    distance, azimuth, elevation = seen.T
    bent, late = np.zeros((2, len(places)))
    if radar.refraction:
        bent, late = rays.table(radar.height_m, scale).look_up(elevation, distance)
    wave = theta["azimuth_sine"] * np.sin(azimuth) + theta["azimuth_cosine"] * np.cos(azimuth)
    return np.stack(
        [
            distance + late + delay_m + theta["range"] + theta["range_gain"] * distance,
            azimuth + theta["azimuth"] + wave,
            elevation + bent + theta["elevation"],
        ],
        axis=1,
    )


def barometric(
    scene: Scene,
    true: np.ndarray,
    aircraft: np.ndarray,
    bias: Mapping[str, float],
    rng: np.random.Generator,
) -> np.ndarray:
    """Heights (n,) by pressure of aircraft at true heights (n,); NaN where none is reported."""
    barometer = scene.barometer
    if barometer is None:
        return np.full(len(true), np.nan)
    own = barometer.aircraft_sigma_m * rng.standard_normal(scene.aircraft)
    step = FOOT_M * rng.choice(barometer.step_ft, scene.aircraft)
    offset, gain = (bias.get(f"barometer.{term}", 0.0) for term in ("height", "height_gain"))
    noise = own[aircraft] + barometer.sigma_m * rng.standard_normal(len(true))
    exact = true + offset + gain * true + scene.noise * noise
    steps = step[aircraft]
    found = steps * np.rint(exact / steps) if scene.noise else exact
    return np.where(rng.random(len(true)) < barometer.reported, found, np.nan)


def _radar_cells(
    radar: Radar, scene: Scene, values: np.ndarray, noise: np.ndarray
) -> dict[str, np.ndarray]:
    degrees = (radar.sigma_azimuth_deg, radar.sigma_elevation_deg)
    values = values + noise * np.array([radar.sigma_range_m, *np.deg2rad(degrees)])
    azimuth = np.mod(np.rad2deg(values[:, 1]), 360.0)
    cells = {"range_m": values[:, 0], "azimuth_deg": azimuth}
    return cells | ({"elevation_deg": np.rad2deg(values[:, 2])} if degrees[1] else {})


def _position_cells(
    reports: PositionReports, places: np.ndarray, noise: np.ndarray
) -> dict[str, np.ndarray]:
    sigmas = np.array([reports.sigma_m, reports.sigma_m, reports.sigma_height_m])
    found = displaced(places, noise * sigmas)
    found[:, :2] = np.rad2deg(found[:, :2])
    return dict(zip(COLUMNS[3:], found.T, strict=True))


def simulate(scene: Scene, rng: np.random.Generator) -> Simulated:
    """Draw flights, biases, detections and noise of one recording."""
    bias, flights = scene.draw(rng), draw_flights(scene, rng)
    delay = scene.delay_sd_m * rng.standard_normal(scene.aircraft)
    parts: dict[str, list[np.ndarray]] = {}
    for sensor in scene.sensors:
        sees = radar_sees if isinstance(sensor, Radar) else positions_seen
        seen = sees(sensor, flights, scene, rng)
        places, n = flights.at(seen.aircraft, seen.time), len(seen.time)
        outlier = rng.random(n) < scene.outliers
        factor = scene.noise * np.where(outlier, scene.outlier_factor, 1.0)
        noise = factor[:, None] * rng.standard_normal((n, 3))
        if isinstance(sensor, Radar):
            late = delay[seen.aircraft]
            values = observe(sensor, places, bias, late, scene.refraction_scale)
            cells = _radar_cells(sensor, scene, values, noise)
        else:
            cells = _position_cells(sensor, places, noise)
        cells["sensor"] = np.full(n, sensor.name, dtype=object)
        cells["time_s"] = seen.time + bias.get(f"{sensor.name}.time", 0.0)
        true = {"true_time": seen.time, "place": places, "aircraft": seen.aircraft}
        empty = {name: np.full(n, np.nan) for name in COLUMNS}
        for name, values in (empty | cells | true | {"outlier": outlier}).items():
            parts.setdefault(name, []).append(values)
    joined = {name: np.concatenate(arrays) for name, arrays in parts.items()}
    return _finished(scene, joined, bias, delay, flights, rng)


def _finished(
    scene: Scene,
    joined: dict[str, np.ndarray],
    bias: dict[str, float],
    delay: np.ndarray,
    flights: Flights,
    rng: np.random.Generator,
) -> Simulated:
    """Put reports in the order of their stamps; add heights by pressure and identities."""
    order = np.argsort(joined["time_s"], kind="stable")
    joined = {name: values[order] for name, values in joined.items()}
    aircraft, n = joined.pop("aircraft"), len(order)
    places = joined.pop("place")
    pressure = barometric(scene, places[:, 2], aircraft, bias, rng)
    wrong = rng.random(n) < scene.wrong
    other = np.mod(aircraft + rng.integers(1, max(scene.aircraft, 2), n), scene.aircraft)
    joined["pressure_altitude_m"] = pressure
    joined["target"] = name_of(np.where(wrong, other, aircraft))
    time, outlier = joined.pop("true_time"), joined.pop("outlier")
    degrees = np.column_stack([np.rad2deg(places[:, :2]), places[:, 2]])
    truth = Truth(bias, time, degrees, aircraft, outlier, wrong, delay, flights)
    return Simulated(joined, scene, truth)
