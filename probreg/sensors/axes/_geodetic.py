"""Positions reported as latitude, longitude and height."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.sensors.axes._axes import Observed
from probreg.sensors.axes._coordinates import Coordinates
from probreg.sensors.axes._ellipsoid import Geodetic, Origin, geodetic, level, on_surface, radii
from probreg.sensors.axes._ellipsoid import position as position_of
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray


@dataclass(frozen=True)
class GeodeticAxes(Coordinates):
    """Latitude, longitude and height as metres: east along the parallel, north, and up.

    East is the length of the target's own parallel from the meridian of the origin, north is
    measured by the curvature of the meridian at the origin, up is the height above the
    ellipsoid. So an error of a metre is a metre, to the share of the height in the radius of
    the earth, and latitude and longitude without a height say where a target is at any height.

    Parameters
    ----------
    origin : tuple of float
        Latitude, longitude (degrees) and height of the common frame's origin.
    dim : int
        Coordinates of the common frame; in the plane of two, targets are on the ellipsoid.
    components : int, optional
        How many are reported, by default as many as the frame has.

    Raises
    ------
    InvalidInputError
        More components than the frame has.
    """

    origin: tuple[float, float, float]
    dim: int = 3
    components: int | None = None

    @cached_property
    def _origin(self) -> Origin:
        return Origin(float(np.deg2rad(self.origin[0])), self.origin[2])

    def values(self, places: FloatArray) -> FloatArray:
        """Values (n, 3) of latitudes, longitudes (degrees) and heights (n, 3)."""
        degrees = np.asarray(places, dtype=float)
        latitude = np.deg2rad(degrees[:, 0])
        away = wrap_angle(np.deg2rad(degrees[:, 1] - self.origin[1]))
        return self._values(Geodetic(latitude, away, degrees[:, 2]))

    def places(self, values: FloatArray) -> FloatArray:
        """Latitudes, longitudes (degrees) and heights (n, 3) of values (n, 2) or (n, 3).

        Heights are NaN where the values have none.
        """
        found = self._geodetic(values, np.full(len(values), np.nan))
        longitude = self.origin[1] + np.rad2deg(found.longitude)
        return np.stack([np.rad2deg(found.latitude), longitude, found.height], axis=1)

    def observe(self, x: FloatArray) -> Observed:
        """East, north and up of positions (n, d)."""
        where = x if self.dim == 3 else on_surface(x, 0.0, self._origin)
        place = geodetic(where, self._origin)
        across, along = radii(place.latitude)
        east, north, up = np.moveaxis(level(place, self._origin), 1, 0)
        # metres on the ground at the target's height for one of the value
        factor = np.ones((len(x), 3))
        factor[:, 0] = 1.0 + place.height / across
        factor[:, 1] = (along + place.height) / radii(self._origin.latitude)[1]
        # the parallel gets shorter to the north
        lean = np.sin(place.latitude) * place.longitude * along / (along + place.height)
        gradient = np.stack([east - (factor[:, 0] * lean)[:, None] * north, north, up], axis=1)
        if self.dim == 2:
            gradient = gradient[:, :, :2] - gradient[:, :, 2:] * (up[:, :2] / up[:, 2:])[:, None]
        q = self._count
        return Observed(self._values(place)[:, :q], gradient[:, :q], factor[:, :q])

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """The reported positions (n, d); without a height at `height`."""
        given = np.zeros(len(values)) if self.dim == 2 else height
        return position_of(self._geodetic(values, given), self._origin)[:, : self.dim]

    def _values(self, place: Geodetic) -> FloatArray:
        across, _ = radii(place.latitude)
        _, along = radii(self._origin.latitude)
        east = across * np.cos(place.latitude) * place.longitude
        north = along * (place.latitude - self._origin.latitude)
        return np.stack([east, north, place.height], axis=1)

    def _geodetic(self, values: FloatArray, height: FloatArray) -> Geodetic:
        latitude = self._origin.latitude + values[:, 1] / radii(self._origin.latitude)[1]
        longitude = values[:, 0] / (radii(latitude)[0] * np.cos(latitude))
        up = np.full(len(values), np.nan) if values.shape[1] == 2 else values[:, 2]
        return Geodetic(latitude, longitude, np.where(np.isnan(up), height, up))
