"""Aircraft on the ellipsoid: straight ones follow great circles, others climb and turn.

Latitude, longitude, height and track are integrated along the curved earth. Where the track only
turns with the meridians, the path is a geodesic.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tests.independent.earth import ECCENTRICITY_SQUARED, EQUATOR_M

STEP_S = 1.0
GRAVITY = 9.81
ROLL_S, PULL_S = 6, 16  # how long it takes to enter a turn and a climb, whole steps
STANDARD_TURN = np.deg2rad(3.0)


class Flights(NamedTuple):
    """Paths of k aircraft at every second.

    Attributes
    ----------
    start : float
        Time of the first second.
    places : ndarray, shape (T, k, 3)
        Latitude, longitude (radians), height.
    rates : ndarray, shape (T, k, 3)
        Their derivatives by time.
    """

    start: float
    places: np.ndarray
    rates: np.ndarray

    def at(self, aircraft: np.ndarray, time: np.ndarray) -> np.ndarray:
        """Places (..., 3) of aircraft (...,) at times (...,): cubics between the seconds.

        Raises
        ------
        ValueError
            Times outside of the flights.
        """
        since = (time - self.start) / STEP_S
        if since.size and not (since.min() >= 0.0 and since.max() <= len(self.places) - 1):
            raise ValueError("times outside of the flights")
        row = np.minimum(since.astype(int), len(self.places) - 2)
        u = (since - row)[..., None]
        near, far = self.places[row, aircraft], self.places[row + 1, aircraft]
        leave, arrive = self.rates[row, aircraft] * STEP_S, self.rates[row + 1, aircraft] * STEP_S
        return (
            (1.0 + 2.0 * u) * (1.0 - u) ** 2 * near
            + u**2 * (3.0 - 2.0 * u) * far
            + u * (1.0 - u) ** 2 * leave
            + u**2 * (u - 1.0) * arrive
        )


class Kind(NamedTuple):
    """How an aircraft flies.

    Attributes
    ----------
    turns, climbs : bool
        Whether some of its legs do.
    """

    turns: bool
    climbs: bool


LEVEL, CLIMBING = Kind(turns=False, climbs=False), Kind(turns=False, climbs=True)
TURNING, BOTH = Kind(turns=True, climbs=False), Kind(turns=True, climbs=True)


def slopes(state: np.ndarray, speed: np.ndarray, turn: np.ndarray, climb: np.ndarray) -> np.ndarray:
    """Derivatives (4, k) of latitude, longitude, height and track (4, k) by time.

    Speed is that over the ellipsoid at the aircraft's own height; `turn` is clockwise, beyond
    what the meridians do.
    """
    latitude, _, height, track = state
    below = 1.0 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2
    prime = EQUATOR_M / np.sqrt(below)
    meridian = prime * (1.0 - ECCENTRICITY_SQUARED) / below
    north = speed * np.cos(track) / (meridian + height)
    east = speed * np.sin(track) / ((prime + height) * np.cos(latitude))
    return np.stack([north, east, climb, turn + east * np.sin(latitude)])


def fly(
    start: np.ndarray, speed: np.ndarray, turn: np.ndarray, climb: np.ndarray, begin: float = 0.0
) -> Flights:
    """Integrate paths.

    Parameters
    ----------
    start : ndarray, shape (4, k)
        Latitude, longitude, height, track.
    speed : ndarray, shape (k,)
    turn, climb : ndarray, shape (T, k)
        Radians and metres a second at every second; linear between.
    begin : float
        Time of the first second.
    """
    state, places, rates = np.asarray(start, dtype=float), [], []
    for now in range(len(turn)):
        first = slopes(state, speed, turn[now], climb[now])
        places.append(state[:3].T)
        rates.append(first[:3].T)
        after = min(now + 1, len(turn) - 1)
        halfway = 0.5 * (turn[now] + turn[after]), 0.5 * (climb[now] + climb[after])
        second = slopes(state + 0.5 * STEP_S * first, speed, *halfway)
        third = slopes(state + 0.5 * STEP_S * second, speed, *halfway)
        fourth = slopes(state + STEP_S * third, speed, turn[after], climb[after])
        state = state + STEP_S / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    return Flights(begin, np.stack(places), np.stack(rates))


def controls(
    kind: Kind, speed: float, height: float, seconds: int, band: tuple, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Turn and climb (seconds,) of one aircraft: straight legs, and every second one of its kind.

    Turns are at most standard ones (3 degrees a second) and at most 30 degrees of bank; climbs
    and descents at most 15 m/s, and none leads out of the band of heights.
    """
    turn, climb = np.zeros(seconds), np.zeros(seconds)
    hardest = min(STANDARD_TURN, GRAVITY * np.tan(np.deg2rad(30.0)) / speed)
    now = int(rng.integers(0, 90))
    while now < seconds:
        leg = slice(now, now + int(rng.integers(30, 120)))
        if kind.turns:
            turn[leg] = rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 1.0) * hardest
        if kind.climbs:
            rate = rng.choice([-1.0, 1.0]) * rng.uniform(3.0, 15.0)
            length = leg.stop - leg.start
            if not band[0] < height + rate * length < band[1]:
                rate = -rate
            if band[0] < height + rate * length < band[1]:
                climb[leg] = rate
                height += rate * length
        now = leg.stop + int(rng.integers(30, 150))
    return _eased(turn, ROLL_S), _eased(climb, PULL_S)


def _eased(values: np.ndarray, seconds: int) -> np.ndarray:
    """Moving average over some seconds, so that nothing turns or climbs at once."""
    padded = np.concatenate([values[:1].repeat(seconds), values])
    return np.convolve(padded, np.full(seconds, 1.0 / seconds), mode="full")[seconds : -seconds + 1]
