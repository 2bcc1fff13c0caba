"""The common frame on the earth: local east, north and up about an origin (WGS 84)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pyproj import Transformer

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray


@dataclass(frozen=True)
class LocalFrame:
    """East, north and up of a place.

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

    @cached_property
    def _transform(self) -> Transformer:
        return Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
            "+step +proj=cart +ellps=WGS84 "
            f"+step +proj=topocentric +ellps=WGS84 +lat_0={self.latitude_deg!r} "
            f"+lon_0={self.longitude_deg!r} +h_0={self.height_m!r}"
        )

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
