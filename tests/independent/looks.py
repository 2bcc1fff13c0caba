"""Who is seen by whom, and when: flights over the region, turning antennas, ranges, horizons."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pyproj import Geod

from tests.independent.earth import earth_centred, look
from tests.independent.flights import Flights, controls, fly
from tests.independent.scene import PositionReports, Radar, Scene

MARGIN_S = 30.0  # flights begin before and end after the recording


class Seen(NamedTuple):
    """Aircraft that one sensor sees: who and when."""

    aircraft: np.ndarray
    time: np.ndarray


def draw_flights(scene: Scene, rng: np.random.Generator) -> Flights:
    """Aircraft that start anywhere in the region and head for another point of it."""
    count, seconds = scene.aircraft, int(scene.duration_s + 2.0 * MARGIN_S) + 2
    geod = Geod(ellps="WGS84")
    ends = []
    for _ in range(2):
        course, far = rng.uniform(0.0, 360.0, count), scene.region_m * np.sqrt(rng.random(count))
        here = (np.full(count, one) for one in scene.centre_deg[::-1])
        longitude, latitude, _ = geod.fwd(*here, course, far)
        ends.append((longitude, latitude))
    track = np.deg2rad(geod.inv(*ends[0], *ends[1])[0])
    speed, height = rng.uniform(*scene.speeds_m_s, count), rng.uniform(*scene.heights_m, count)
    kinds = rng.integers(0, len(scene.kinds), count)
    steered = [
        controls(scene.kinds[kind], v, h, seconds, scene.heights_m, rng)
        for kind, v, h in zip(kinds, speed, height, strict=True)
    ]
    turn, climb = np.stack([t for t, _ in steered], 1), np.stack([c for _, c in steered], 1)
    start = np.stack([*np.deg2rad(ends[0][::-1]), height, track])
    return fly(start, speed, turn, climb, begin=-MARGIN_S)


def look_times(radar: Radar, flights: Flights, scene: Scene, phase: float) -> np.ndarray:
    """When the beam of a rotating radar meets each aircraft, shape (turns, k)."""
    turns = np.arange(int(scene.duration_s / radar.scan_s) + 1)
    count = flights.places.shape[1]
    aircraft = np.broadcast_to(np.arange(count), (len(turns), count))
    north = phase + radar.scan_s * turns[:, None] - radar.scan_s
    azimuth = np.full(aircraft.shape, np.pi)
    for _ in range(4):
        time = north + radar.scan_s * azimuth / (2.0 * np.pi)
        seen = look(radar.place, flights.at(aircraft, time))[..., 1]
        # the turn nearest to the last one: an aircraft that crosses north is met once a scan
        azimuth = azimuth + np.angle(np.exp(1j * (seen - azimuth)))
    return time


def _covered(scene: Scene, places: np.ndarray) -> np.ndarray:
    """Whether places are near enough to the centre to be reported."""
    centre = np.array([*np.deg2rad(scene.centre_deg), 0.0])
    far = np.linalg.norm(earth_centred(places) - earth_centred(centre), axis=-1)
    return far < 1.3 * scene.region_m


def radar_sees(radar: Radar, flights: Flights, scene: Scene, rng: np.random.Generator) -> Seen:
    time = look_times(radar, flights, scene, rng.uniform(0.0, radar.scan_s))
    aircraft = np.broadcast_to(np.arange(time.shape[1]), time.shape)
    places = flights.at(aircraft, time)
    distance, _, elevation = np.moveaxis(look(radar.place, places), -1, 0)
    low, high = np.deg2rad([radar.min_elevation_deg, radar.max_elevation_deg])
    there = (distance < radar.max_range_m) & (elevation > low) & (elevation < high)
    there &= (time >= 0.0) & (time < scene.duration_s) & _covered(scene, places)
    there &= rng.random(time.shape) < scene.detection
    return Seen(aircraft[there], time[there])


def positions_seen(
    reports: PositionReports, flights: Flights, scene: Scene, rng: np.random.Generator
) -> Seen:
    count = int(1.25 * scene.duration_s / reports.interval_s) + 3
    gaps = reports.interval_s * rng.uniform(0.8, 1.2, (count, scene.aircraft))
    time = np.cumsum(gaps, axis=0) - reports.interval_s * rng.random(scene.aircraft)
    aircraft = np.broadcast_to(np.arange(scene.aircraft), time.shape)
    equipped = rng.random(scene.aircraft) < reports.equipped
    there = (time >= 0.0) & (time < scene.duration_s) & equipped
    who, when = aircraft[there], time[there]
    covered = _covered(scene, flights.at(who, when))
    return Seen(who[covered], when[covered])
