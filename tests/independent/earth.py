"""Places on the ellipsoid (WGS 84), earth-centred coordinates, and what a sensor sees of them."""

from __future__ import annotations

import numpy as np
from pyproj import Transformer

_TO_CENTRE = Transformer.from_pipeline("+proj=cart +ellps=WGS84")
EQUATOR_M, ECCENTRICITY_SQUARED = 6_378_137.0, 0.006_694_379_990_141_33


def earth_centred(places: np.ndarray) -> np.ndarray:
    """Coordinates (..., 3) of latitude, longitude (radians) and height (..., 3)."""
    latitude, longitude, height = np.moveaxis(np.asarray(places, dtype=float), -1, 0)
    found = _TO_CENTRE.transform(longitude, latitude, height, radians=True)
    return np.stack(found, axis=-1)


def place_of(centred: np.ndarray) -> np.ndarray:
    """Invert `earth_centred`."""
    x, y, z = np.moveaxis(np.asarray(centred, dtype=float), -1, 0)
    longitude, latitude, height = _TO_CENTRE.transform(x, y, z, radians=True, direction="INVERSE")
    return np.stack([latitude, longitude, height], axis=-1)


def east_north_up(place: np.ndarray) -> np.ndarray:
    """Unit vectors east, north and up (..., 3, 3) at places (..., 3), earth-centred, as rows."""
    latitude, longitude = place[..., 0], place[..., 1]
    zero = np.zeros_like(latitude)
    up = np.stack(
        [
            np.cos(latitude) * np.cos(longitude),
            np.cos(latitude) * np.sin(longitude),
            np.sin(latitude),
        ],
        axis=-1,
    )
    east = np.stack([-np.sin(longitude), np.cos(longitude), zero], axis=-1)
    return np.stack([east, np.cross(up, east), up], axis=-2)


def look(site: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Slant range, azimuth from true north and elevation (..., 3) of places from a site (3,)."""
    line = earth_centred(places) - earth_centred(site)
    east, north, up = np.moveaxis(line @ east_north_up(site).T, -1, 0)
    distance = np.linalg.norm(line, axis=-1)
    return np.stack([distance, np.arctan2(east, north), np.arcsin(up / distance)], axis=-1)


def displaced(places: np.ndarray, move: np.ndarray) -> np.ndarray:
    """Places moved by metres east, north and up (..., 3), along straight lines."""
    axes = east_north_up(places)
    return place_of(earth_centred(places) + np.einsum("...ij,...i->...j", axes, move))
