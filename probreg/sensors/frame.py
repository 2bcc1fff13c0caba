"""The common frame on the earth: east, north and up at an origin (WGS 84), rigid and so exact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pyproj import Transformer

from probreg.errors import InvalidInputError
from probreg.sensors.placement import Placement
from probreg.typing import FloatArray


@dataclass(frozen=True)
class LocalFrame:
    """East, north and up of a place: x = R0 (X - X_O) of earth-centred coordinates X.

    Parameters
    ----------
    latitude_deg, longitude_deg : float
    height_m : float
        Above the ellipsoid.

    Raises
    ------
    InvalidInputError
        A place that is not on the earth.
    """

    latitude_deg: float
    longitude_deg: float
    height_m: float = 0.0

    def __post_init__(self) -> None:
        for name in ("latitude_deg", "longitude_deg", "height_m"):
            object.__setattr__(self, name, float(getattr(self, name)))
        fine = abs(self.latitude_deg) < 90.0 and abs(self.longitude_deg) <= 360.0
        if not (fine and np.isfinite(self.height_m)):
            raise InvalidInputError(
                f"({self.latitude_deg}, {self.longitude_deg}, {self.height_m}) is no latitude, "
                "longitude in degrees and height in metres."
            )

    @property
    def origin(self) -> tuple[float, float, float]:
        """Latitude, longitude (degrees) and height."""
        return self.latitude_deg, self.longitude_deg, self.height_m

    @cached_property
    def _transform(self) -> Transformer:
        return Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
            "+step +proj=cart +ellps=WGS84 "
            f"+step +proj=topocentric +ellps=WGS84 +lat_0={self.latitude_deg!r} "
            f"+lon_0={self.longitude_deg!r} +h_0={self.height_m!r}"
        )

    @cached_property
    def _axes(self) -> FloatArray:
        return level_axes(np.array(self.latitude_deg), np.array(self.longitude_deg))

    def from_geodetic(self, places: FloatArray) -> FloatArray:
        """Convert (latitude, longitude, height), shape (..., 3), degrees and metres, to x, y, z."""
        latitude, longitude, height = np.moveaxis(np.asarray(places, dtype=float), -1, 0)
        return np.stack(self._transform.transform(longitude, latitude, height), axis=-1)

    def to_geodetic(self, positions: FloatArray) -> FloatArray:
        """Convert positions (..., 2) or (..., 3) to latitude, longitude, height (..., 3)."""
        positions = np.asarray(positions, dtype=float)
        x, y = positions[..., 0], positions[..., 1]
        z = positions[..., 2] if positions.shape[-1] == 3 else np.zeros_like(x)
        longitude, latitude, height = self._transform.transform(x, y, z, direction="INVERSE")
        return np.stack([latitude, longitude, height], axis=-1)

    def placement(self, places: FloatArray) -> Placement:
        """Place sensors at latitude, longitude (degrees) and height, shape (..., 3), each level.

        Their axes are M = R_S R0', with R the rotation from earth-centred axes to east, north
        and up.
        """
        places = np.asarray(places, dtype=float)
        own = level_axes(places[..., 0], places[..., 1])
        return Placement(self.from_geodetic(places), own @ self._axes.T)

    def height(self, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Heights (...,) above the ellipsoid of positions (..., 3), and their derivatives (..., 3).

        The derivative is the unit vector up at the position, in the axes of this frame.
        """
        places = self.to_geodetic(positions)
        latitude, longitude = np.deg2rad(places[..., 0]), np.deg2rad(places[..., 1])
        level = np.cos(latitude)
        up = np.stack(
            [level * np.cos(longitude), level * np.sin(longitude), np.sin(latitude)], axis=-1
        )
        return places[..., 2], up @ self._axes.T

    def convergence(self, positions: FloatArray) -> FloatArray:
        """Angle (...,) from the frame's north to true north at positions, clockwise, radians.

        Meridians meet at the poles: a radar 100 km east of an origin in the middle latitudes
        has its north a degree from the frame's. Added to an azimuth from true north.
        """
        latitude, longitude, _ = np.deg2rad(np.moveaxis(self.to_geodetic(positions), -1, 0))
        here, away = np.deg2rad(self.latitude_deg), longitude - np.deg2rad(self.longitude_deg)
        east = -np.sin(latitude) * np.sin(away)
        north = np.cos(latitude) * np.cos(here) + np.sin(latitude) * np.sin(here) * np.cos(away)
        return np.arctan2(east, north)


def level_axes(latitude_deg: FloatArray, longitude_deg: FloatArray) -> FloatArray:
    """Rotations (..., 3, 3) from earth-centred axes to east, north and up at places (...,)."""
    latitude, longitude = np.deg2rad(latitude_deg), np.deg2rad(longitude_deg)
    s, c, along, across = np.sin(latitude), np.cos(latitude), np.cos(longitude), np.sin(longitude)
    rows = [
        np.stack([-across, along, np.zeros_like(s)], axis=-1),
        np.stack([-s * along, -s * across, c], axis=-1),
        np.stack([c * along, c * across, s], axis=-1),
    ]
    return np.stack(rows, axis=-2)
