"""Heights above the earth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.sensors.axes._axes import Observed
from probreg.sensors.axes._ellipsoid import Origin, geodetic, level
from probreg.typing import BoolArray, FloatArray


@dataclass(frozen=True)
class HeightAxes:
    """Heights above the earth, of a frame east, north, up at an origin on it.

    Parameters
    ----------
    latitude, height_m : float, optional
        Of the origin, radians and metres above the ellipsoid (WGS-84); without a latitude the
        earth is flat and the height is the third coordinate plus that of the origin.
    """

    latitude: float | None = None
    height_m: float = 0.0

    @property
    def angles(self) -> BoolArray:
        """None."""
        return np.zeros(1, dtype=bool)

    @property
    def vertical(self) -> BoolArray:
        """All."""
        return np.ones(1, dtype=bool)

    def observe(self, x: FloatArray) -> Observed:
        """Height above the ellipsoid, whose normal there is the gradient."""
        if self.latitude is None:
            up = np.tile([0.0, 0.0, 1.0], (len(x), 1))
            value = x[:, 2] + self.height_m
        else:
            origin = Origin(self.latitude, self.height_m)
            place = geodetic(x, origin)
            value, up = place.height, level(place, origin)[:, 2]
        return Observed(value[:, None], up[:, None, :], np.ones((len(x), 1)))

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """Nowhere: a height alone is no place."""
        return np.full((len(values), 3), np.nan)
