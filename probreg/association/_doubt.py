"""Reports that are far from the path of the target whose identity they carry."""

from __future__ import annotations

import dataclasses

import numba
import numpy as np

from probreg.association._placed import place
from probreg.association._spots import Spots
from probreg.recordings import UNKNOWN, Recording, Setup
from probreg.typing import FloatArray, IntArray

_BESIDE = 3  # neighbours before and after
_LEAST = 3  # lines through neighbours that must pass a report
OFF_PATH, TOO_FAST = 1, 2  # why an identity is doubted; 0 where it is believed


def doubt_identities(recording: Recording, setup: Setup, theta: FloatArray) -> Recording:
    """Take away identities that the reports before and after contradict: see `doubts`."""
    believed = doubts(recording, setup, theta) == 0
    return dataclasses.replace(recording, target=np.where(believed, recording.target, UNKNOWN))


def doubts(recording: Recording, setup: Setup, theta: FloatArray) -> IntArray:
    """Why the reports before and after contradict each identity (n,): 0 where they do not.

    A report keeps its identity if three of the straight lines through pairs of its neighbours
    of that identity pass it horizontally within the gate, widened by six standard deviations of
    its own noise, and, where heights are known, not far above or below; and if it could have
    flown to half of them at the setup's largest speed. Else it is `OFF_PATH` or, where speed
    alone speaks against it, `TOO_FAST`. Neighbours that are wrong themselves may thus be many:
    their lines go elsewhere. Heights are doubted with the report that they came with.

    Parameters
    ----------
    recording : Recording
    setup : Setup
    theta : ndarray, shape (p,)
        The biases as far as they are known.
    """
    placed = place(recording, setup, theta)
    spots = placed.spots
    # a bearing is nowhere in the plane: it keeps its identity, and the noise law judges it
    known = np.flatnonzero((recording.target != UNKNOWN) & np.isfinite(spots.where[:, 0]))
    order = known[np.lexsort((placed.time[known], recording.target[known]))]
    found = np.zeros(len(recording), dtype=np.int64)
    found[order] = _support(
        np.ascontiguousarray(recording.target[order], dtype=np.int64),
        placed.time[order],
        spots.take(order),
        placed.gate[order],
        placed.window,
        setup.max_speed_m_s,
    )
    return found if recording.beside is None else found[recording.beside]


@numba.njit(cache=True)
def _support(
    target: IntArray,
    time: FloatArray,
    spots: Spots,
    gate: FloatArray,
    window: float,
    speed: float,
) -> IntArray:
    """0 where enough lines through its neighbours, if there are any, pass each report."""
    n = len(time)
    where = spots.where
    doubted = np.zeros(n, dtype=np.int64)
    near = np.empty(2 * _BESIDE, dtype=np.int64)
    for i in range(n):
        found = 0
        for step in (-1, 1):
            j, taken = i + step, 0
            while taken < _BESIDE and 0 <= j < n and target[j] == target[i]:
                if abs(time[j] - time[i]) > 2.0 * window:
                    break
                near[found] = j
                found, taken, j = found + 1, taken + 1, j + step
        reached = 0
        for x in range(found):
            square = 0.0
            for c in range(2):
                square += (where[i, c] - where[near[x], c]) ** 2
            reach = gate[i] + speed * abs(time[i] - time[near[x]])
            reached += square <= reach * reach
        made, passed = _lines(i, near[:found], time, spots, gate[i])
        if passed < min(_LEAST, made):
            doubted[i] = OFF_PATH
        elif 2 * reached < found:
            doubted[i] = TOO_FAST
    return doubted


@numba.njit(cache=True)
def _lines(i: int, near: IntArray, time: FloatArray, spots: Spots, gate: float) -> tuple[int, int]:
    """How many lines through pairs of neighbours there are, and how many pass report i."""
    where, height, room = spots
    made, passed = 0, 0
    for x in range(len(near)):
        for y in range(x + 1, len(near)):
            a, b = near[x], near[y]
            gap = time[b] - time[a]
            reach = max(abs(time[i] - time[a]), abs(time[i] - time[b]))
            if abs(gap) < 0.5 * reach or gap == 0.0:
                continue  # too far to extrapolate
            made += 1
            share, square = (time[i] - time[a]) / gap, 0.0
            for c in range(2):
                line = where[a, c] + share * (where[b, c] - where[a, c])
                square += (where[i, c] - line) ** 2
            # NaN where a height is not known, and that is never too high
            up = height[a] + share * (height[b] - height[a]) - height[i]
            high = abs(up) > room[i] + max(room[a], room[b])
            passed += square <= gate**2 and not high
    return made, passed
