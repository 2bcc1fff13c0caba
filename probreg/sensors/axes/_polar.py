"""Range, azimuth and elevation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors.axes._axes import Observed, Site
from probreg.sensors.axes._ellipsoid import EARTH_RADIUS_M, Origin, on_surface
from probreg.sensors.refraction import refraction
from probreg.typing import BoolArray, FloatArray
from probreg.validation import finite_array

COMPONENTS = ("range", "azimuth", "elevation")
_STEP = 1e-4  # of elevation, for the slope of refraction
_ROUNDS = 2  # of taking refraction out where a report is placed


class _Bending(NamedTuple):
    """What refraction adds to range and elevation, and to the latter with a change of it."""

    range: FloatArray | float
    elevation: FloatArray | float
    slope: FloatArray | float


@dataclass(frozen=True, eq=False)
class PolarAxes:
    """Range, azimuth and elevation, or some of them, from a place of its own.

    Parameters
    ----------
    position : ndarray, shape (d,)
    components : tuple of str
        Of "range", "azimuth", "elevation", in that order.
    rotation : ndarray, shape (d, d), optional
        M, from the common frame to the sensor's own level: east, north, up.
    from_north : bool
        Azimuth from y, clockwise, instead of from x, counter-clockwise.
    height : float, optional
        Of the sensor above the ellipsoid, metres; without it the earth is flat, and heights are
        third coordinates.
    refracted : bool
        Whether ranges and elevations are those of the standard atmosphere.

    Raises
    ------
    InvalidInputError
        Components that are none, an elevation in the plane, M that is no rotation, refraction
        without a height on the earth.
    """

    position: FloatArray
    components: tuple[str, ...] = COMPONENTS
    rotation: FloatArray | None = None
    from_north: bool = False
    height: float | None = None
    refracted: bool = False
    _which: tuple[int, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        position = finite_array("position", self.position, (None,))
        d = len(position)
        M = np.eye(d) if self.rotation is None else finite_array("rotation", self.rotation, (d, d))
        if d not in (2, 3) or np.abs(M @ M.T - np.eye(d)).max() > 1e-9:
            raise InvalidInputError("a place has 2 or 3 coordinates, and M must be a rotation.")
        known = COMPONENTS[:d]
        which = tuple(known.index(c) for c in self.components if c in known)
        if len(which) != len(self.components) or not which or list(which) != sorted(set(which)):
            raise InvalidInputError(f"components {self.components} must be some of {known}.")
        if self.refracted and (d == 2 or self.height is None):
            raise InvalidInputError("refraction needs three dimensions and a height on the earth.")
        for name, value in (("position", position), ("rotation", M), ("_which", which)):
            object.__setattr__(self, name, value)

    @property
    def angles(self) -> BoolArray:
        """Azimuth and elevation."""
        return np.array(self._which) > 0

    @property
    def vertical(self) -> BoolArray:
        """The elevation."""
        return np.array(self._which) == 2

    def observe(self, x: FloatArray) -> Observed:
        """Range, azimuth and elevation of positions (n, d).

        Of refraction the gradient has what changes elevation with elevation, a twentieth of it
        at half a degree; the rest is below half a hundredth (see `tests/sensors/test_axes.py`).
        """
        line, M = x - self.position, np.asarray(self.rotation)
        n, d = line.shape
        local = line @ M.T
        ground = np.hypot(local[:, 0], local[:, 1])
        distance = ground if d == 2 else np.hypot(ground, local[:, 2])
        # on the vertical there is no direction, and every slope but that of the range is zero
        cosine, sine = local.T[:2] / np.where(ground > 0.0, ground, 1.0)
        line = line / np.where(distance > 0.0, distance, 1.0)[:, None]
        elevation = np.arctan2(local[:, 2], ground) if d == 3 else np.zeros(n)
        added = self._bending(distance, elevation)
        value, factor = np.empty((n, len(self._which))), np.ones((n, len(self._which)))
        gradient = np.empty((n, len(self._which), d))
        for j, which in enumerate(self._which):
            if which == 0:
                value[:, j], gradient[:, j] = distance + added.range, line
            elif which == 1:
                azimuth = local[:, :2] if self.from_north else local[:, 1::-1]
                value[:, j], factor[:, j] = np.arctan2(*azimuth.T), ground
                sign = -1.0 if self.from_north else 1.0
                gradient[:, j] = np.outer(-sign * sine, M[0]) + np.outer(sign * cosine, M[1])
            else:
                value[:, j] = elevation + added.elevation
                factor[:, j] = np.where(ground > 0.0, distance, 0.0)
                rise, steep = line @ M[-1], 1.0 + added.slope
                gradient[:, j] = np.outer(steep * np.hypot(cosine, sine) * np.cos(elevation), M[-1])
                gradient[:, j] -= np.outer(steep * rise * cosine, M[0])
                gradient[:, j] -= np.outer(steep * rise * sine, M[1])
        return Observed(value, gradient, factor)

    def _bending(self, distance: FloatArray, elevation: FloatArray) -> _Bending:
        if not self.refracted:
            return _Bending(0.0, 0.0, 0.0)
        height = float(self.height or 0.0)
        here = refraction(distance, elevation, height)
        slope: FloatArray | float = 0.0
        if 2 in self._which:
            above = refraction(distance, elevation + _STEP, height)
            slope = (above.elevation - here.elevation) / _STEP
        return _Bending(here.range, here.elevation, slope)

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """Positions of reports with range and azimuth; without elevation at `height`."""
        d = len(self.position)
        if self._which[:2] != (0, 1):
            return np.full((len(values), d), np.nan)
        azimuth = 0.5 * np.pi - values[:, 1] if self.from_north else values[:, 1]
        direction = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
        distance = values[:, 0]
        if d == 2:
            return self.position + (distance[:, None] * direction) @ np.asarray(self.rotation)
        up = self._up(values, height)
        straight = values
        for _ in range(_ROUNDS if self.refracted else 0):
            ratio = np.clip(up / np.maximum(distance, 1.0), -1.0, 1.0)
            added = refraction(distance, np.arcsin(ratio), float(self.height or 0.0))
            straight = (
                values
                - np.stack([added.range, 0.0 * up, added.elevation], 1)[:, : len(self._which)]
            )
            distance, up = straight[:, 0], self._up(straight, height)
        ground = np.sqrt(np.maximum(distance**2 - up**2, (0.05 * distance) ** 2))
        local = np.concatenate([ground[:, None] * direction, up[:, None]], axis=1)
        return self.position + local @ np.asarray(self.rotation)

    def _up(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """Heights (n,) above the sensor's own level."""
        distance = values[:, 0]
        if len(self._which) == 3:
            return distance * np.sin(values[:, 2])
        if self.height is None:
            return height - self.position[2]
        # the earth falls away from the sensor's level
        centre = EARTH_RADIUS_M + self.height
        up: FloatArray = (height - self.height) * (EARTH_RADIUS_M + 0.5 * (height + self.height))
        return (up - 0.5 * distance**2) / centre


def polar_axes(
    position: tuple[float, ...], components: tuple[str, ...], from_north: bool, site: Site
) -> PolarAxes:
    """Axes of a sensor at a site.

    With a place on the earth it is level there and counts from true north; in the plane that
    is a turn by the convergence of the meridians. Others, at `position` (2,) or (3,), have the
    axes of the common frame; a missing height is zero above the earth.
    """
    own, frame, place = np.asarray(position, dtype=float), site.frame, site.place
    if site.dim == 2:
        turned = frame is not None and place is not None
        return PolarAxes(own[:2], components, _turn(own[:2], site) if turned else None, from_north)
    if frame is None:
        return PolarAxes(np.append(own, np.zeros(3 - len(own))), components, None, from_north)
    if place is not None:
        stand = frame.placement(np.asarray(place))
        where, M, height = stand.position, stand.level, float(place[2])
    else:
        origin = Origin(float(np.deg2rad(frame.latitude_deg)), frame.height_m)
        where = own if len(own) == 3 else on_surface(own[None], 0.0, origin)[0]
        M, height = np.eye(3), float(frame.height(where)[0])
    return PolarAxes(where, components, M, from_north, height, site.refraction)


def _turn(position: FloatArray, site: Site) -> FloatArray | None:
    """Rotation (2, 2) to the sensor's own north; None where it is that of the frame."""
    assert site.frame is not None
    angle = float(site.frame.convergence(position))
    if angle == 0.0:
        return None
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])
