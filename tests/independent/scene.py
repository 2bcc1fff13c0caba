"""Every number of a simulated recording. Units stand in the names, as an engineer writes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tests.independent.flights import BOTH, CLIMBING, LEVEL, TURNING, Kind

ANGLES = ("azimuth", "elevation", "azimuth_sine", "azimuth_cosine")
FOOT_M = 0.3048


def si(term: str, value: float) -> float:
    """Turn a bias into SI units: angles are written in degrees."""
    return float(np.deg2rad(value)) if term in ANGLES else float(value)


@dataclass(frozen=True)
class Radar:
    """A rotating radar.

    Parameters
    ----------
    name : str
    latitude_deg, longitude_deg, height_m : float
    sigma_range_m, sigma_azimuth_deg : float
    sigma_elevation_deg : float
        Zero for one that measures no elevation.
    scan_s : float
        Time of a turn.
    max_range_m, min_elevation_deg, max_elevation_deg : float
        What it covers, by true elevation.
    refraction : bool
        Whether its reports are refracted; otherwise its processor has corrected them.
    unknown : mapping of str to float
        Terms it has and their standard deviations, from which each recording draws: "range",
        "azimuth", "elevation", "range_gain", "azimuth_sine", "azimuth_cosine", "time".
    """

    name: str
    latitude_deg: float
    longitude_deg: float
    height_m: float
    sigma_range_m: float = 50.0
    sigma_azimuth_deg: float = 0.08
    sigma_elevation_deg: float = 0.0
    scan_s: float = 5.0
    max_range_m: float = 250e3
    min_elevation_deg: float = 0.2
    max_elevation_deg: float = 40.0
    refraction: bool = True
    unknown: Mapping[str, float] = field(default_factory=lambda: {"range": 60.0, "azimuth": 0.3})

    @property
    def place(self) -> np.ndarray:
        """Latitude, longitude (radians) and height."""
        degrees = np.array([self.latitude_deg, self.longitude_deg])
        return np.array([*np.deg2rad(degrees), self.height_m])


@dataclass(frozen=True)
class PositionReports:
    """Positions that aircraft themselves report, such as ADS-B.

    Parameters
    ----------
    name : str
    interval_s : float
        Mean time between reports of one aircraft; each is up to a fifth earlier or later.
    sigma_m : float
        Of east and of north.
    sigma_height_m : float
        Of the geometric height.
    equipped : float
        Share of the aircraft that report.
    unknown : mapping of str to float
        "time": the stamp is so much later than the position.
    """

    name: str = "adsb"
    interval_s: float = 4.0
    sigma_m: float = 20.0
    sigma_height_m: float = 15.0
    equipped: float = 0.8
    unknown: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Barometer:
    """Heights by pressure: report = height + offset + share * height + noise, in steps.

    Parameters
    ----------
    step_ft : tuple of float
        One of these for each aircraft.
    sigma_m : float
        Of each report, before rounding.
    aircraft_sigma_m : float
        Of a constant error of each aircraft.
    reported : float
        Share of the reports that carry a height.
    unknown : mapping of str to float
        "height" (metres) and "height_gain" (share of height).
    """

    step_ft: tuple[float, ...] = (25.0, 100.0)
    sigma_m: float = 5.0
    aircraft_sigma_m: float = 0.0
    reported: float = 1.0
    unknown: Mapping[str, float] = field(default_factory=dict)
    name: str = "barometer"


@dataclass(frozen=True)
class Scene:
    """A recording of aircraft by several sensors.

    Parameters
    ----------
    radars : tuple of Radar
    positions : PositionReports, optional
    barometer : Barometer, optional
        Without one no report of a radar carries a height.
    fixed : mapping of str to float
        Biases that are not drawn, by name ("adsb.time", "barometer.height"); in metres,
        seconds and degrees.
    aircraft : int
        All in the air all the time.
    duration_s : float
    centre_deg : tuple of float
        Latitude and longitude of the middle of the traffic, and origin of the setup file.
    region_m : float
        Aircraft start within this distance of the centre and are reported within 1.3 of it.
    heights_m, speeds_m_s : tuple of float
        Lowest and highest.
    kinds : tuple of Kind
        One of these for each aircraft.
    detection : float
        Probability that a radar sees an aircraft in a turn.
    delay_sd_m : float
        Standard deviation, in range, of the delay of each transponder.
    outliers : float
        Share of reports with `outlier_factor` times the noise.
    wrong : float
        Share of reports under the identity of another aircraft.
    refraction_scale : float
        Refractivity over that of the standard atmosphere.
    noise : float
        Factor of every noise; zero for exact reports, heights not rounded.
    """

    radars: tuple[Radar, ...]
    positions: PositionReports | None = None
    barometer: Barometer | None = field(default_factory=Barometer)
    fixed: Mapping[str, float] = field(default_factory=dict)
    aircraft: int = 45
    duration_s: float = 600.0
    centre_deg: tuple[float, float] = (50.0, 9.0)
    region_m: float = 120e3
    heights_m: tuple[float, float] = (1_000.0, 12_000.0)
    speeds_m_s: tuple[float, float] = (120.0, 260.0)
    kinds: tuple[Kind, ...] = (LEVEL, LEVEL, CLIMBING, TURNING, BOTH)
    detection: float = 0.95
    delay_sd_m: float = 0.0
    outliers: float = 0.0
    outlier_factor: float = 10.0
    wrong: float = 0.0
    refraction_scale: float = 1.0
    noise: float = 1.0

    @property
    def sensors(self) -> tuple[Radar | PositionReports, ...]:
        """Radars, then what reports positions."""
        return (*self.radars, *((self.positions,) if self.positions else ()))

    def draw(self, rng: np.random.Generator) -> dict[str, float]:
        """Biases of one recording by name, SI units."""
        owners = (*self.sensors, *((self.barometer,) if self.barometer else ()))
        drawn = {
            f"{owner.name}.{term}": si(term, sd * rng.standard_normal())
            for owner in owners
            for term, sd in owner.unknown.items()
        }
        fixed = {name: si(name.split(".", 1)[1], value) for name, value in self.fixed.items()}
        return drawn | fixed
