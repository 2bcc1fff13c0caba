"""Radio rays in an atmosphere that thins out exponentially above a spherical earth.

A ray is followed step by step; nothing here knows the formulas it is there to judge.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

RADIUS_M = 6_371_000.0
REFRACTIVITY = 315e-6  # at sea level
SCALE_HEIGHT_M = 7_350.0


class Rays(NamedTuple):
    """Rays (k,) at equal steps (T,) of their length.

    Attributes
    ----------
    chord, elevation : ndarray, shape (T, k)
        Straight distance and true elevation of where the ray is, seen from where it starts.
    excess : ndarray, shape (T, k)
        Optical path less the chord, metres.
    height, angle : ndarray, shape (T, k)
        Height above the sphere, and the ray's own elevation there.
    """

    chord: np.ndarray
    elevation: np.ndarray
    excess: np.ndarray
    height: np.ndarray
    angle: np.ndarray


def _slopes(state: np.ndarray, start: float, scale: float) -> np.ndarray:
    """Derivatives by length of radius, angle at the centre, elevation, and path excess."""
    rise, _, angle, _ = state
    dry = scale * REFRACTIVITY * np.exp(-(rise + start - RADIUS_M) / SCALE_HEIGHT_M)
    bend = -dry / SCALE_HEIGHT_M / (1.0 + dry)
    full = rise + start
    turn = np.cos(angle) / full
    return np.stack([np.sin(angle), turn, turn + np.cos(angle) * bend, dry])


def trace(
    elevation: np.ndarray, height: float, step: float, count: int, scale: float = 1.0
) -> Rays:
    """Follow rays that leave at apparent elevations (k,) from a height, in RK4 steps.

    Parameters
    ----------
    elevation : ndarray, shape (k,)
    height : float
        Of the start above the sphere.
    step : float
        Metres.
    count : int
        Number of steps.
    scale : float
        Of the refractivity.
    """
    start = RADIUS_M + height  # radii are kept relative to it, so that nothing is rounded away
    elevation = np.asarray(elevation, dtype=float)
    state = np.stack([np.zeros_like(elevation)] * 2 + [elevation, np.zeros_like(elevation)])
    states = [state]
    for _ in range(count):
        first = _slopes(state, start, scale)
        second = _slopes(state + 0.5 * step * first, start, scale)
        third = _slopes(state + 0.5 * step * second, start, scale)
        fourth = _slopes(state + step * third, start, scale)
        state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        states.append(state)
    rise, angle, own, dry = np.stack(states, axis=1)
    along = (start + rise) * np.sin(angle)
    up = rise - 2.0 * (start + rise) * np.sin(0.5 * angle) ** 2
    chord = np.hypot(along, up)
    length = step * np.arange(count + 1.0)[:, None]
    seen = np.where(chord > 0.0, np.arctan2(up, along), elevation)
    return Rays(chord, seen, dry + (length - chord), height + rise, own)


class Table(NamedTuple):
    """Deflection of rays from one height by apparent elevation (k,) and chord (T,).

    Attributes
    ----------
    elevation, chord : ndarray
    bending : ndarray, shape (T, k)
        Apparent less true elevation.
    excess : ndarray, shape (T, k)
        Optical path less the chord.
    """

    elevation: np.ndarray
    chord: np.ndarray
    bending: np.ndarray
    excess: np.ndarray

    def look_up(self, elevation: np.ndarray, chord: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bending and excess (n,) towards true elevations and at distances (n,).

        Raises
        ------
        ValueError
            Beyond the table.
        """
        low, high = self.elevation[0] + 2e-3, self.elevation[-1] - 2e-3
        if elevation.size and not (
            low <= elevation.min() and elevation.max() <= high and chord.max() <= self.chord[-1]
        ):
            raise ValueError("beyond the table of rays")
        apparent = elevation.copy()
        for _ in range(6):
            apparent = elevation + self._between(self.bending, apparent, chord)
        return apparent - elevation, self._between(self.excess, apparent, chord)

    def _between(self, values: np.ndarray, apparent: np.ndarray, chord: np.ndarray) -> np.ndarray:
        column = np.clip(np.searchsorted(self.elevation, apparent) - 1, 0, len(self.elevation) - 2)
        left, right = self.elevation[column], self.elevation[column + 1]
        across = (apparent - left) / (right - left)
        places = chord / self.chord[1]
        row = np.minimum(places.astype(int), len(self.chord) - 2)
        along = places - row
        near, far = (
            (1.0 - across) * values[k, column] + across * values[k, column + 1]
            for k in (row, row + 1)
        )
        return (1.0 - along) * near + along * far


@cache
def table(height: float, scale: float = 1.0, farthest: float = 450e3) -> Table:
    """Trace a fan of rays, from a degree below level to nearly upright."""
    degrees = [np.arange(-1.0, 5.0, 0.02), np.arange(5.0, 20.0, 0.1), np.arange(20.0, 90.0, 0.5)]
    elevation = np.deg2rad(np.concatenate(degrees))
    step = 500.0
    rays = trace(elevation, height, step, int(farthest / step) + 2, scale)
    chord = np.arange(0.0, farthest + step, step)
    fan = range(len(elevation))
    bending = elevation - rays.elevation
    bending, excess = (
        np.stack([np.interp(chord, rays.chord[:, k], values[:, k]) for k in fan], axis=1)
        for values in (bending, rays.excess)
    )
    return Table(elevation, chord, bending, excess)
