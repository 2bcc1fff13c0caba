"""Aircraft that cross an area on straight legs and gentle turns, one after another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.typing import FloatArray, IntArray

ENTRY_RADIUS_M = 120_000.0  # flights enter on this circle
AIM_RADIUS_M = 60_000.0  # and head for a point within this one
SPEED_M_S = (180.0, 250.0)
HEIGHT_M = (3_000.0, 11_000.0)
FLIGHT_S = 1_200.0
LEG_S = 60.0
TURN_M_S2 = 1.0  # largest lateral acceleration of a turn, every second leg


def advance(
    speed: FloatArray, heading: FloatArray, rate: FloatArray, time: FloatArray
) -> FloatArray:
    """Displacement (..., 2) along an arc: the chord, at half the turn."""
    half = 0.5 * rate * time
    chord = speed * time * np.sinc(half / np.pi)
    return np.stack([chord * np.cos(heading + half), chord * np.sin(heading + half)], axis=-1)


@dataclass(frozen=True, eq=False)
class Flights:
    """Slots that always hold one aircraft each: when a flight ends the next one enters.

    Attributes
    ----------
    offset : ndarray, shape (slots,)
        Time into its first flight at time zero, seconds.
    speed, height : ndarray, shape (flights,)
    heading, rate : ndarray, shape (flights, legs)
        At the start of each leg, radians from the x axis, and radians per second.
    corner : ndarray, shape (flights, legs, 2)
        Where each leg starts, metres.
    """

    offset: FloatArray
    speed: FloatArray
    height: FloatArray
    heading: FloatArray
    rate: FloatArray
    corner: FloatArray

    def flight(self, slot: IntArray, time: FloatArray) -> IntArray:
        """Which flight a slot holds at a time."""
        turn = np.floor((time + self.offset[slot]) / FLIGHT_S).astype(np.int64)
        return turn * len(self.offset) + slot

    def position(self, slot: IntArray, time: FloatArray) -> FloatArray:
        """Positions (n, 3) of the aircraft in slots (n,) at times (n,)."""
        flight = self.flight(slot, time)
        since = np.mod(time + self.offset[slot], FLIGHT_S)
        leg = np.minimum((since / LEG_S).astype(np.int64), self.rate.shape[1] - 1)
        heading, rate = self.heading[flight, leg], self.rate[flight, leg]
        step = advance(self.speed[flight], heading, rate, since - leg * LEG_S)
        return np.column_stack([self.corner[flight, leg] + step, self.height[flight]])


def draw_flights(slots: int, duration: float, rng: np.random.Generator) -> Flights:
    """Draw every flight of `slots` aircraft at a time over `duration` seconds."""
    count = slots * (int(duration / FLIGHT_S) + 2)
    legs = round(FLIGHT_S / LEG_S)
    bearing = rng.uniform(-np.pi, np.pi, count)
    entry = ENTRY_RADIUS_M * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    radius, angle = AIM_RADIUS_M * np.sqrt(rng.random(count)), rng.uniform(-np.pi, np.pi, count)
    towards = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1) - entry
    speed, height = rng.uniform(*SPEED_M_S, count), rng.uniform(*HEIGHT_M, count)
    rate = rng.uniform(-TURN_M_S2, TURN_M_S2, (count, legs)) / speed[:, None]
    rate[:, ::2] = 0.0
    turned = np.cumsum(rate * LEG_S, axis=1) - rate * LEG_S
    heading = np.arctan2(towards[:, 1], towards[:, 0])[:, None] + turned
    steps = advance(speed[:, None], heading, rate, np.array(LEG_S))
    corner = entry[:, None] + np.cumsum(steps, axis=1) - steps
    return Flights(rng.uniform(0.0, FLIGHT_S, slots), speed, height, heading, rate, corner)
