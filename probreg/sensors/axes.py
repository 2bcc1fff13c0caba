"""What kinds of report say of a state, in their own axes, scaled to metres.

A sensor at p whose level is turned by M sees l = M (x - p) of a target at x, all in one rigid
frame. Each kind gives the noise-free report h(x), a factor rho that makes its errors metres, and
H = rho dh/dx. Planar and spatial frames alike.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import BoolArray, FloatArray
from probreg.validation import finite_array

EARTH_AXIS_M, EARTH_FLATTENING = 6_378_137.0, 1.0 / 298.257223563  # WGS-84
EARTH_RADIUS_M = 6_371_000.0  # good enough where only curvature counts
COMPONENTS = ("range", "azimuth", "elevation")


class Observed(NamedTuple):
    """Noise-free reports of q components and their sensitivity.

    Attributes
    ----------
    value : ndarray, shape (n, q)
        h(x), metres and radians.
    gradient : ndarray, shape (n, q, d)
        H = rho dh/dx.
    factor : ndarray, shape (n, q)
        rho, metres a unit of the component.
    """

    value: FloatArray
    gradient: FloatArray
    factor: FloatArray


class Axes(Protocol):
    """A kind of report."""

    @property
    def angles(self) -> BoolArray:
        """Which components are angles, (q,): their residuals are wrapped."""

    @property
    def vertical(self) -> BoolArray:
        """Which components say something of the height, (q,)."""

    def observe(self, x: FloatArray) -> Observed:
        """Noise-free reports of positions (n, d)."""

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """Positions (n, d) of reports (n, q), NaN where they do not say; a guess to start from.

        `height` (n,) is taken where the report gives none.
        """


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

    Raises
    ------
    InvalidInputError
        Components that are none, an elevation in the plane, M that is no rotation.
    """

    position: FloatArray
    components: tuple[str, ...] = COMPONENTS
    rotation: FloatArray | None = None
    from_north: bool = False
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
        """Range, azimuth and elevation of positions (n, d)."""
        local = (x - self.position) @ np.asarray(self.rotation).T
        n, d = local.shape
        ground = np.hypot(local[:, 0], local[:, 1])
        if (ground == 0.0).any():
            raise InvalidInputError("a target is on the vertical of a sensor: no azimuth there.")
        distance = ground if d == 2 else np.hypot(ground, local[:, 2])
        cosine, sine = local[:, 0] / ground, local[:, 1] / ground
        value, factor = np.empty((n, 3)), np.ones((n, 3))
        slope = np.zeros((n, 3, d))
        value[:, 0], slope[:, 0] = distance, local / distance[:, None]
        sign = -1.0 if self.from_north else 1.0
        value[:, 1] = (
            np.arctan2(local[:, 0], local[:, 1])
            if self.from_north
            else np.arctan2(local[:, 1], local[:, 0])
        )
        factor[:, 1] = ground
        slope[:, 1, 0], slope[:, 1, 1] = -sign * sine, sign * cosine
        if d == 3:
            up = local[:, 2] / distance
            value[:, 2], factor[:, 2] = np.arctan2(local[:, 2], ground), distance
            slope[:, 2] = np.stack([-up * cosine, -up * sine, ground / distance], axis=1)
        which = list(self._which)
        return Observed(value[:, which], slope[:, which] @ self.rotation, factor[:, which])

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """Positions of reports with range and azimuth; without elevation at `height`."""
        d = len(self.position)
        if self._which[:2] != (0, 1):
            return np.full((len(values), d), np.nan)
        distance, azimuth = values[:, 0], values[:, 1]
        up: FloatArray
        if self.from_north:
            azimuth = 0.5 * np.pi - azimuth
        if d == 2:
            up = np.zeros(len(values))
        elif len(self._which) == 3:
            up = distance * np.sin(values[:, 2])
        else:
            # the earth falls away from the sensor's level
            up = height - self.position[2] - distance**2 / (2.0 * EARTH_RADIUS_M)
        ground = np.sqrt(np.maximum(distance**2 - up**2, (0.05 * distance) ** 2))
        local = np.stack([ground * np.cos(azimuth), ground * np.sin(azimuth), up], axis=1)[:, :d]
        return self.position + local @ np.asarray(self.rotation)


@dataclass(frozen=True)
class PositionAxes:
    """Positions in the common frame, (x, y) or (x, y, z)."""

    dim: int

    @property
    def angles(self) -> BoolArray:
        """None."""
        return np.zeros(self.dim, dtype=bool)

    @property
    def vertical(self) -> BoolArray:
        """The third."""
        return np.arange(self.dim) == 2

    def observe(self, x: FloatArray) -> Observed:
        """The positions themselves."""
        n = len(x)
        return Observed(x, np.tile(np.eye(self.dim), (n, 1, 1)), np.ones((n, self.dim)))

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """The reports themselves."""
        return values


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
            value, up = _above_ellipsoid(x, self.latitude, self.height_m)
        return Observed(value[:, None], up[:, None, :], np.ones((len(x), 1)))

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """Nowhere: a height alone is no place."""
        return np.full((len(values), 3), np.nan)


def fall(position: FloatArray, velocity: FloatArray, radius_m: float) -> FloatArray:
    """Acceleration (n, d) of level flight about an earth whose centre is `radius_m` below zero."""
    away = position + np.array([0.0, 0.0, radius_m])
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    up = away / distance
    level = velocity - np.einsum("nd,nd->n", velocity, up)[:, None] * up
    down: FloatArray = -np.einsum("nd,nd->n", level, level)[:, None] / distance * up
    return down


def _above_ellipsoid(
    x: FloatArray, latitude: float, height: float
) -> tuple[FloatArray, FloatArray]:
    """Heights (n,) and normals (n, 3) of positions in a frame at longitude zero."""
    a, f = EARTH_AXIS_M, EARTH_FLATTENING
    e2 = f * (2.0 - f)
    sin0, cos0 = np.sin(latitude), np.cos(latitude)
    across = a / np.sqrt(1.0 - e2 * sin0**2)
    # east, axis of the earth, away from it, at the origin's meridian
    east = x[:, 0]
    outward = (across + height) * cos0 - sin0 * x[:, 1] + cos0 * x[:, 2]
    north = (across * (1.0 - e2) + height) * sin0 + cos0 * x[:, 1] + sin0 * x[:, 2]
    ring = np.hypot(outward, east)
    # Bowring (1985), exact to a millimetre at aircraft heights
    b = a * (1.0 - f)
    reduced = np.arctan2(north * a, ring * b)
    geodetic = np.arctan2(
        north + e2 / (1.0 - e2) * b * np.sin(reduced) ** 3,
        ring - e2 * a * np.cos(reduced) ** 3,
    )
    sine, cosine = np.sin(geodetic), np.cos(geodetic)
    value = ring * cosine + north * sine - a * np.sqrt(1.0 - e2 * sine**2)
    normal = np.stack([cosine * east / ring, cosine * outward / ring, sine], axis=1)
    # back to east, north, up of the origin
    up = np.stack(
        [
            normal[:, 0],
            cos0 * normal[:, 2] - sin0 * normal[:, 1],
            cos0 * normal[:, 1] + sin0 * normal[:, 2],
        ],
        axis=1,
    )
    return value, up
