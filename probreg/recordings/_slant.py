"""Slant range and azimuth of a radar on the round earth, with a height, into the common frame."""

from __future__ import annotations

import numpy as np

from probreg.sensors.frame import LocalFrame
from probreg.typing import FloatArray

EARTH_RADIUS_M = 6_371_000.0  # only to start from; the ellipsoid corrects it
ROUNDS = 3  # of the correction; the second leaves millimetres


def raised(frame: LocalFrame, plane: FloatArray, height_m: FloatArray) -> FloatArray:
    """Places (..., 3) at x and y (..., 2) of a frame and at heights (...,) above the ellipsoid."""
    local = np.concatenate([plane, np.zeros_like(plane[..., :1])], axis=-1)
    for _ in range(ROUNDS):
        local[..., 2] += height_m - frame.to_geodetic(local)[..., 2]
    return frame.to_geodetic(local)


def site(frame: LocalFrame, position: FloatArray, height_m: float) -> LocalFrame:
    """Frame of a place given by x and y in another frame and its height above the ellipsoid."""
    return LocalFrame(*raised(frame, np.asarray(position)[:2], np.array(height_m)).tolist())


def target_places(
    radar: LocalFrame, slant_m: FloatArray, azimuth: FloatArray, height_m: FloatArray
) -> FloatArray:
    """Latitude, longitude and height (n, 3) of targets; NaN where no target can be.

    Parameters
    ----------
    radar : LocalFrame
        About the radar.
    slant_m, azimuth, height_m : ndarray, shape (n,)
        Slant range, azimuth from true north clockwise (radians), height above the ellipsoid.
    """
    centre = EARTH_RADIUS_M + radar.height_m
    with np.errstate(invalid="ignore", divide="ignore"):
        sine = (EARTH_RADIUS_M + height_m) ** 2 - centre**2 - slant_m**2
        up = sine / (2.0 * centre)
        for _ in range(ROUNDS):
            level = np.sqrt(slant_m**2 - up**2)
            local = np.stack([level * np.sin(azimuth), level * np.cos(azimuth), up], axis=-1)
            places = np.full(local.shape, np.nan)
            real = np.isfinite(local).all(axis=-1)
            places[real] = radar.to_geodetic(local[real])
            up = up + height_m - places[..., 2]
    return places
