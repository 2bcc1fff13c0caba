"""Air traffic seen by rotating radars at different places, each with its own clock and scan.

Unlike the papers' scenes it returns a `Recording`: reports of a target are never simultaneous.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import Recording, Setup
from probreg.scenarios._flights import ENTRY_RADIUS_M, Flights, draw_flights
from probreg.sensors import Radar2D, Radar3D, Sensor
from probreg.sensors.geometry import wrap_angle
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import positive_number

RING_M = 50_000.0  # the radars stand on this circle
BLIND_RANGE_M = 2_000.0  # a radar does not see what is above it
FIRST_ADDRESS = 0x400000
ESTIMATED = ("range", "azimuth")  # what an engineer asks for without knowing more


def radars(
    count: int = 3, dim: int = 2, sigma_range_m: float = 50.0, sigma_azimuth_deg: float = 0.1
) -> tuple[Sensor, ...]:
    """Radars "radar1", "radar2", ... on a circle, azimuth from north; elevation as azimuth.

    Raises
    ------
    InvalidInputError
        A dimension other than 2 and 3.
    """
    if dim not in (2, 3):
        raise InvalidInputError(f"dim is {dim}; a radar has 2 or 3.")
    sigma = float(np.deg2rad(sigma_azimuth_deg))
    angles = np.pi * (2.0 * np.arange(count) / count - 1.0)
    found: list[Sensor] = []
    for k, (x, y) in enumerate(zip(RING_M * np.cos(angles), RING_M * np.sin(angles), strict=True)):
        name = f"radar{k + 1}"
        if dim == 2:
            found.append(Radar2D((x, y), sigma_range_m, sigma, name, from_north=True))
        else:
            here = (x, y, 100.0)
            found.append(Radar3D(here, sigma_range_m, sigma, sigma, name, from_north=True))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class TrafficScene:
    """Every number of the scene.

    Parameters
    ----------
    reports : int
        Total over all sensors; it sets the length of the recording.
    sensors : tuple of Sensor
        Radars, and position sensors as references.
    scan_s : tuple of float
        Rotation period of each sensor's antenna, seconds; repeated if there are more sensors.
    aircraft : int
        At any one time; each stays for twenty minutes and another follows.
    biases : mapping of str to float, optional
        By name, SI units: a report component ("radar1.range"), "radar1.range_gain" (share of
        the true range) or "radar1.time" (seconds that its clock is ahead). Biases not named
        are zero. None draws range and azimuth of each radar from its default prior.
    wrong_share : float
        Share of the pairs of reports of two sensors under one identity that are of different
        aircraft.
    outlier_share : float
        Share of the reports with `outlier_factor` times the noise.
    detection : float
        Probability that a sensor detects an aircraft in range during one rotation.
    max_range_m : float
        Of every radar.

    Raises
    ------
    InvalidInputError
        Numbers out of range, biases of sensors or terms that are not there.
    """

    reports: int = 5_000
    sensors: tuple[Sensor, ...] = field(default_factory=radars)
    scan_s: tuple[float, ...] = (4.0, 5.0, 6.0)
    aircraft: int = 40
    biases: Mapping[str, float] | None = None
    wrong_share: float = 0.0
    outlier_share: float = 0.0
    outlier_factor: float = 10.0
    detection: float = 0.9
    max_range_m: float = 200_000.0

    def __post_init__(self) -> None:
        if self.reports < 1 or self.aircraft < 1 or not self.sensors or not self.scan_s:
            raise InvalidInputError("reports, aircraft, sensors and scan_s must be 1 or more.")
        if not (0.0 <= self.wrong_share < 1.0 and 0.0 <= self.outlier_share <= 1.0):
            raise InvalidInputError("wrong_share and outlier_share are shares, from 0 to 1.")
        if not 0.0 < self.detection <= 1.0:
            raise InvalidInputError(f"detection is {self.detection}; a probability above 0.")
        if self.wrong_share > 0.0 and self.aircraft < 2:
            raise InvalidInputError("wrong identities need two aircraft or more.")
        for number in (*self.scan_s, self.outlier_factor, self.max_range_m):
            positive_number("scan_s, outlier_factor or max_range_m", number)
        placing = all(sensor.gives_position for sensor in self.sensors)
        if len({s.dim for s in self.sensors}) > 1 or not placing:
            raise InvalidInputError("sensors must be radars or position sensors of one dimension.")
        known = {f"{s.name}.{term}" for s in self.sensors for term in self._terms(s)}
        strange = set(self.biases or ()) - known
        if strange:
            raise InvalidInputError(f"no biases {sorted(strange)}; known: {sorted(known)}.")

    @staticmethod
    def _terms(sensor: Sensor) -> tuple[str, ...]:
        gain = ("range_gain",) if "range" in sensor.bias_names else ()
        return (*sensor.bias_names, *gain, "time")

    @property
    def setup(self) -> Setup:
        """What the engineer knows: range and azimuth of each radar, and what `biases` names."""
        asked = {}
        for sensor in self.sensors:
            named = [t for t in self._terms(sensor) if f"{sensor.name}.{t}" in (self.biases or ())]
            usual = [term for term in ESTIMATED if term in sensor.bias_names]
            asked[sensor.name] = tuple(dict.fromkeys([*usual, *named]))
        return Setup(self.sensors, asked)

    @property
    def wrong_identities(self) -> float:
        """Share of reports under a wrong identity: a pair is right if both of its reports are."""
        return float(1.0 - np.sqrt(1.0 - self.wrong_share))


@dataclass(frozen=True, eq=False)
class TrafficTruth:
    """Ground truth, hidden from the estimators.

    Attributes
    ----------
    bias : dict of str to float
        By name, SI units.
    time : ndarray, shape (n,)
        True time of each report, seconds.
    positions : ndarray, shape (n, d)
        Of the aircraft that each report is of, metres.
    target : ndarray of int, shape (n,)
        Its true identity, a number of the recording's labels.
    wrong, outlier : ndarray of bool, shape (n,)
        Under a wrong identity; with more noise.
    """

    bias: dict[str, float]
    time: FloatArray
    positions: FloatArray
    target: IntArray
    wrong: BoolArray
    outlier: BoolArray


@dataclass(frozen=True, eq=False)
class _Looks:
    """Which sensor saw which slot when, in order of true time."""

    sensor: IntArray
    slot: IntArray
    time: FloatArray
    positions: FloatArray

    def take(self, rows: IntArray) -> _Looks:
        return _Looks(self.sensor[rows], self.slot[rows], self.time[rows], self.positions[rows])


def _look(
    scene: TrafficScene, flights: Flights, duration: float, rng: np.random.Generator
) -> _Looks:
    """Every look of every sensor at an aircraft in range, detected or not by chance."""
    parts = []
    for k, sensor in enumerate(scene.sensors):
        scan = scene.scan_s[k % len(scene.scan_s)]
        turns = np.arange(int(duration / scan))
        # an aircraft keeps its place in the turn, near enough
        time = scan * (turns[:, None] + rng.random(scene.aircraft))
        slot = np.broadcast_to(np.arange(scene.aircraft), time.shape)
        seen = rng.random(time.shape) < scene.detection
        time, slot = time[seen], slot[seen]
        where = flights.position(slot, time)[:, : sensor.dim]
        if sensor.position is not None:
            distance = np.hypot(*(where[:, :2] - np.asarray(sensor.position[:2])).T)
            near = (distance > BLIND_RANGE_M) & (distance < scene.max_range_m)
            time, slot, where = time[near], slot[near], where[near]
        parts.append((np.full(len(time), k), slot, time, where))
    looks = _Looks(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    return looks.take(np.argsort(looks.time, kind="stable"))


def _watch(scene: TrafficScene, rng: np.random.Generator) -> tuple[Flights, _Looks]:
    """Fly and look for as long as it takes to see the wanted number of reports."""
    scans = [scene.scan_s[k % len(scene.scan_s)] for k in range(len(scene.sensors))]
    rate = scene.detection * scene.aircraft * np.sum(1.0 / np.asarray(scans))
    duration = 1.1 * scene.reports / rate + 2.0 * max(scans)
    for _ in range(10):
        flights = draw_flights(scene.aircraft, duration, rng)
        looks = _look(scene, flights, duration, rng)
        if len(looks.time) >= scene.reports:
            return flights, looks.take(np.arange(scene.reports))
        duration *= 1.5
    raise InvalidInputError(
        f"the sensors see {len(looks.time)} of {scene.reports} reports in {duration:.0f} s; "
        f"enlarge max_range_m (aircraft enter {ENTRY_RADIUS_M / 1e3:.0f} km from the centre)."
    )


def _draw_biases(scene: TrafficScene, rng: np.random.Generator) -> dict[str, float]:
    drawn = {}
    asked = scene.setup.biases
    for sensor in scene.sensors:
        prior = dict(zip(sensor.bias_names, sensor.bias_sd, strict=True))
        for term in asked[sensor.name]:
            name = f"{sensor.name}.{term}"
            if scene.biases is None:
                drawn[name] = float(prior[term] * rng.standard_normal())
            else:
                drawn[name] = float(scene.biases.get(name, 0.0))
    return drawn


def _report(
    sensor: Sensor, positions: FloatArray, bias: Mapping[str, float], noise: FloatArray
) -> FloatArray:
    own = np.array([bias.get(f"{sensor.name}.{term}", 0.0) for term in sensor.bias_names])
    true = sensor.to_report(positions)
    reports = true + own + noise
    if "range" in sensor.bias_names:
        column = sensor.bias_names.index("range")
        reports[:, column] += bias.get(f"{sensor.name}.range_gain", 0.0) * true[:, column]
    if "azimuth" in sensor.bias_names:
        column = sensor.bias_names.index("azimuth")
        reports[:, column] = wrap_angle(reports[:, column])
    return reports


def simulate(
    scene: TrafficScene, rng: np.random.Generator
) -> tuple[Recording, Setup, TrafficTruth]:
    """Draw flights, biases, looks and noise; reports are in order of the time they carry."""
    bias = _draw_biases(scene, rng)
    flights, looks = _watch(scene, rng)
    n, slots = scene.reports, scene.aircraft
    outlier = rng.random(n) < scene.outlier_share
    wrong = rng.random(n) < scene.wrong_identities
    other = np.mod(looks.slot + rng.integers(1, max(slots, 2), n), slots)
    flown = flights.flight(looks.slot, looks.time)
    said = np.where(wrong, flights.flight(other, looks.time), flown)
    numbers, both = np.unique(np.concatenate([flown, said]), return_inverse=True)
    values = np.full((n, max(len(s.bias_names) for s in scene.sensors)), np.nan)
    time = looks.time.copy()
    for k, sensor in enumerate(scene.sensors):
        rows = np.flatnonzero(looks.sensor == k)
        noise = sensor.sample_noise(rng, len(rows), looks.positions[rows])
        noise[outlier[rows]] *= scene.outlier_factor
        reports = _report(sensor, looks.positions[rows], bias, noise)
        values[rows, : reports.shape[1]] = reports
        time[rows] += bias.get(f"{sensor.name}.time", 0.0)
    order = np.argsort(time, kind="stable")
    labels = tuple(f"{FIRST_ADDRESS + number:06x}" for number in numbers)
    recording = Recording(
        scene.sensors, looks.sensor[order], time[order], values[order], both[n:][order], labels
    )
    seen = looks.take(order)
    truth = TrafficTruth(
        bias, seen.time, seen.positions, both[:n][order], wrong[order], outlier[order]
    )
    return recording, scene.setup, truth
