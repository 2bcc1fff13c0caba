"""The ellipsoid (WGS 84) about an origin on it, in compact form for many positions at once.

Positions are east, north and up of the origin; longitudes count from its meridian. `LocalFrame`
gives the same through pyproj.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.typing import FloatArray

EARTH_AXIS_M, EARTH_FLATTENING = 6_378_137.0, 1.0 / 298.257223563  # WGS-84
EARTH_RADIUS_M = 6_371_000.0  # good enough where only curvature counts
_E2 = EARTH_FLATTENING * (2.0 - EARTH_FLATTENING)
_ROUNDS = 3  # of putting a position onto the surface; the second leaves millimetres


class Origin(NamedTuple):
    """Latitude (radians) and height (metres) of a frame's origin."""

    latitude: float
    height: float


class Geodetic(NamedTuple):
    """Latitudes, longitudes from the origin's meridian (radians), heights: (n,) each."""

    latitude: FloatArray
    longitude: FloatArray
    height: FloatArray


def radii(latitude: FloatArray | float) -> tuple[FloatArray, FloatArray]:
    """Radii of curvature across the meridian and along it, metres."""
    below = 1.0 - _E2 * np.sin(latitude) ** 2
    across = EARTH_AXIS_M / np.sqrt(below)
    return across, across * (1.0 - _E2) / below


def geodetic(x: FloatArray, origin: Origin) -> Geodetic:
    """Latitudes, longitudes and heights of positions (n, 3); Bowring (1985), twice."""
    sin0, cos0 = np.sin(origin.latitude), np.cos(origin.latitude)
    across = EARTH_AXIS_M / np.sqrt(1.0 - _E2 * sin0**2)
    # away from the earth's axis in the origin's meridian, and along the axis
    outward = (across + origin.height) * cos0 - sin0 * x[:, 1] + cos0 * x[:, 2]
    axial = (across * (1.0 - _E2) + origin.height) * sin0 + cos0 * x[:, 1] + sin0 * x[:, 2]
    ring = np.hypot(outward, x[:, 0])
    a, b = EARTH_AXIS_M, EARTH_AXIS_M * (1.0 - EARTH_FLATTENING)
    sine, cosine = _unit(a * axial, b * ring)  # of the reduced latitude, then of the geodetic one
    for left in (1, 0):
        above = axial + _E2 / (1.0 - _E2) * b * (sine * sine * sine)
        sine, cosine = _unit(above, ring - _E2 * a * (cosine * cosine * cosine))
        if left:
            sine, cosine = _unit(b * sine, a * cosine)
    height = ring * cosine + axial * sine - a * np.sqrt(1.0 - _E2 * sine**2)
    return Geodetic(np.arctan2(sine, cosine), np.arctan2(x[:, 0], outward), height)


def _unit(sine: FloatArray, cosine: FloatArray) -> tuple[FloatArray, FloatArray]:
    size = np.hypot(sine, cosine)
    return sine / size, cosine / size


def position(place: Geodetic, origin: Origin) -> FloatArray:
    """Positions (n, 3) of places: the inverse of `geodetic`."""
    across, _ = radii(place.latitude)
    ring = (across + place.height) * np.cos(place.latitude)
    axial = (across * (1.0 - _E2) + place.height) * np.sin(place.latitude)
    sin0, cos0 = np.sin(origin.latitude), np.cos(origin.latitude)
    across0 = EARTH_AXIS_M / np.sqrt(1.0 - _E2 * sin0**2)
    outward = ring * np.cos(place.longitude) - (across0 + origin.height) * cos0
    axial = axial - (across0 * (1.0 - _E2) + origin.height) * sin0
    return np.stack(
        [
            ring * np.sin(place.longitude),
            cos0 * axial - sin0 * outward,
            sin0 * axial + cos0 * outward,
        ],
        axis=1,
    )


def level(place: Geodetic, origin: Origin) -> FloatArray:
    """Unit vectors east, north and up (n, 3, 3) at places, as rows in the origin's axes."""
    s, c = np.sin(place.latitude), np.cos(place.latitude)
    along, across = np.cos(place.longitude), np.sin(place.longitude)
    # outward in the origin's meridian, east of it, and along the earth's axis
    zero = np.zeros_like(s)
    outward = np.stack([-across, -s * along, c * along], axis=1)
    east = np.stack([along, -s * across, c * across], axis=1)
    axial = np.stack([zero, c, s], axis=1)
    sin0, cos0 = np.sin(origin.latitude), np.cos(origin.latitude)
    return np.stack([east, cos0 * axial - sin0 * outward, sin0 * axial + cos0 * outward], axis=2)


def on_surface(plane: FloatArray, height: FloatArray | float, origin: Origin) -> FloatArray:
    """Positions (n, 3) above x and y (n, 2) of the frame, at heights above the ellipsoid."""
    x = np.concatenate([plane, np.zeros((len(plane), 1))], axis=1)
    for _ in range(_ROUNDS):
        x[:, 2] += height - geodetic(x, origin).height
    return x


def fall(position: FloatArray, velocity: FloatArray, radius_m: float) -> FloatArray:
    """Acceleration (n, d) of level flight about an earth whose centre is `radius_m` below zero."""
    away = position + np.array([0.0, 0.0, radius_m])
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    up = away / distance
    level = velocity - np.einsum("nd,nd->n", velocity, up)[:, None] * up
    down: FloatArray = -np.einsum("nd,nd->n", level, level)[:, None] / distance * up
    return down
