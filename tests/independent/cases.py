"""Scenes by name: one for each claim about geometry and about what may be unknown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from tests.independent.scene import Barometer, PositionReports, Radar, Scene

OFFSET_M, SHARE = 60.0, 0.02  # what a barometric error is expected to be
AS_USUAL = {"range": 60.0, "azimuth": 0.3}


def four_radars(spread: float = 1.0, **every: object) -> tuple[Radar, ...]:
    """Radars about (50 N, 9 E): 80 to 131 km apart, or `spread` times that."""
    sites = (
        ("north", 0.50, -0.10, 240.0, 4.0, 50.0, 0.08),
        ("east", 0.05, 0.85, 410.0, 5.0, 60.0, 0.10),
        ("south", -0.55, 0.25, 120.0, 6.0, 40.0, 0.07),
        ("west", -0.15, -0.95, 90.0, 10.0, 70.0, 0.12),
    )
    return tuple(
        Radar(
            name,
            50.0 + spread * latitude,
            9.0 + spread * longitude,
            height,
            sigma_range_m=sigma,
            sigma_azimuth_deg=angle,
            scan_s=scan,
            unknown=AS_USUAL,
            **every,
        )
        for name, latitude, longitude, height, scan, sigma, angle in sites
    )


def easy() -> Scene:
    """Four radars, a reference, heights without a systematic error."""
    return Scene(four_radars(), PositionReports())


def near() -> Scene:
    """Radars within 60 km of each other, and what is within 60 km of them; low and slow."""
    coverage = {"max_range_m": 60e3, "min_elevation_deg": 0.5, "max_elevation_deg": 60.0}
    band, speeds = (1_000.0, 6_000.0), (120.0, 200.0)
    return Scene(
        four_radars(spread=0.45, **coverage),
        PositionReports(),
        region_m=40e3,
        heights_m=band,
        speeds_m_s=speeds,
    )


def wide() -> Scene:
    """Radars up to 250 km apart."""
    return Scene(four_radars(spread=1.9), PositionReports(), region_m=200e3)


def radar3d() -> Scene:
    """One of the radars measures elevation, 116 km from the origin."""
    scene = wide()
    upright = replace(
        scene.radars[1],
        sigma_elevation_deg=0.15,
        unknown={**AS_USUAL, "elevation": 0.2},
    )
    return replace(scene, radars=(scene.radars[0], upright, *scene.radars[2:]))


def all_terms() -> Scene:
    """Every term of every radar, and of the barometer."""
    scene = radar3d()
    further = {"range_gain": 5e-4, "azimuth_sine": 0.1, "azimuth_cosine": 0.1, "time": 0.3}
    radars = tuple(replace(r, unknown={**r.unknown, **further}) for r in scene.radars)
    barometer = Barometer(unknown={"height": OFFSET_M, "height_gain": SHARE})
    return replace(scene, radars=radars, barometer=barometer)


def no_reference() -> Scene:
    """As `easy`, and no aircraft reports its position."""
    return replace(easy(), positions=None)


def barometric(offset_m: float, reference: bool) -> Scene:
    """Heights by pressure that are all off by so much."""
    scene = easy() if reference else no_reference()
    barometer = Barometer(unknown={"height": OFFSET_M, "height_gain": SHARE})
    fixed = {"barometer.height": offset_m, "barometer.height_gain": 0.0}
    return replace(scene, barometer=barometer, fixed=fixed)


def late_adsb() -> Scene:
    """Reported positions are 0.6 s old when they are stamped."""
    scene = replace(easy(), fixed={"adsb.time": 0.6})
    return replace(scene, positions=PositionReports(unknown={"time": 0.5}))


def no_heights(radars: int, reference: bool = False) -> Scene:
    """Slant ranges and azimuths of aircraft whose height nothing reports."""
    scene = easy() if reference else no_reference()
    return replace(scene, radars=scene.radars[:radars], barometer=None)


def transponder_delays() -> Scene:
    """Every aircraft answers early or late by its own constant, 30 m of range."""
    return replace(easy(), delay_sd_m=30.0)


CASES: dict[str, Callable[[], Scene]] = {
    "easy": easy,
    "near": near,
    "wide": wide,
    "radar3d": radar3d,
    "all_terms": all_terms,
    "no_reference": no_reference,
    "barometric_100": lambda: barometric(100.0, reference=True),
    "barometric_200": lambda: barometric(200.0, reference=True),
    "barometric_100_no_reference": lambda: barometric(100.0, reference=False),
    "barometric_200_no_reference": lambda: barometric(200.0, reference=False),
    "late_adsb": late_adsb,
    "no_heights_4": lambda: no_heights(4),
    "no_heights_3": lambda: no_heights(3),
    "no_heights_2": lambda: no_heights(2),
    "transponder_delays": transponder_delays,
}
