"""Tracks of each sensor, and which of them are of one target."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numba
import numpy as np

from probreg.association._placed import Placed
from probreg.association._spots import CLIMB_M_S, Spots, between
from probreg.association.nearest_neighbours import assign
from probreg.recordings import UNKNOWN, Setup
from probreg.typing import BoolArray, FloatArray, IntArray

_LEAST = 4  # reports of a track
_COMMON = 4  # reports at common times that a match needs
_MISSED = 3.0  # scans after which a track ends
_OVERLAP = 0.2  # of the shorter track: two tracks of one sensor are then two targets


def common_tracks(placed: Placed, setup: Setup) -> IntArray:
    """Identities (n,) by tracks: one number for all tracks that are of one target."""
    track = np.full(len(placed.sensor), UNKNOWN)
    for k in np.unique(placed.sensor):
        rows = np.flatnonzero((placed.sensor == k) & np.isfinite(placed.spots.where[:, 0]))
        if not rows.size:
            continue  # bearings have no tracks in the plane
        rows = rows[np.argsort(placed.time[rows], kind="stable")]
        own = link(placed, rows, setup)
        track[rows[own != UNKNOWN]] = own[own != UNKNOWN] + track.max() + 1
    return _matched(placed, setup, track)


def link(placed: Placed, rows: IntArray, setup: Setup) -> IntArray:
    """Track number (m,) of some of one sensor's reports in order of time, -1 for none.

    Reports of half a scan are assigned at once to the tracks predicted with constant velocity
    (`association.assign`); reports left over start tracks; short tracks are given up.
    """
    time, spots = placed.time[rows], placed.spots.take(rows)
    where, gate = spots.where[:, :2], np.minimum(placed.gate[rows], setup.gate_m)
    track = np.full(len(time), UNKNOWN)
    scan = float(placed.intervals[placed.sensor[rows[0]]])
    if not scan > 0.0:
        scan = max(float(time[-1] - time[0]), 1.0)
    alive = _Alive.none()
    fresh = 0
    edges = np.searchsorted(time, np.arange(time[0], time[-1] + 0.5 * scan, 0.5 * scan))
    for a, b in zip(edges, [*edges[1:], len(time)], strict=True):
        if a == b:
            continue
        alive = alive.which(time[a] - time[alive.latest] <= _MISSED * scan)
        step = time[a:b, None] - time[alive.latest]
        ahead = alive.last + alive.velocity * step[..., None]
        away = np.linalg.norm(where[a:b, None] - ahead, axis=2)
        away[_elsewhere(spots, np.arange(a, b), alive.latest, step)] = np.inf
        # a track of one report may go anywhere; prediction errors grow with time
        drift = setup.acceleration_m_s2 * np.sqrt(scan)
        reach = np.where(alive.reports == 1, setup.max_speed_m_s, drift) * np.abs(step)
        limit = gate[a:b, None] + reach
        none = np.zeros((0, 2), dtype=np.int64)
        pairs = assign((away / limit) ** 2, 1.0) if len(alive.reports) else none
        i, j = a + pairs[:, 0], pairs[:, 1]
        track[i] = alive.number[j]
        alive.move(j, i, time, where)
        rest = np.flatnonzero(track[a:b] == UNKNOWN) + a
        track[rest] = fresh + np.arange(len(rest))
        alive = alive.joined(rest, track[rest], where)
        fresh += len(rest)
    short = np.bincount(track, minlength=fresh) < _LEAST
    track[short[track]] = UNKNOWN
    return _renumbered(track)


def _elsewhere(spots: Spots, new: IntArray, latest: IntArray, step: FloatArray) -> BoolArray:
    """Whether reports (m,) are too far above or below the latest of tracks (k,), (m, k)."""
    high = np.abs(spots.height[new, None] - spots.height[latest])
    climb = CLIMB_M_S * np.abs(step)
    found: BoolArray = high > spots.room[new, None] + spots.room[latest] + climb
    return found


class _Alive(NamedTuple):
    """Tracks that go on, one a row, and the number of their last report."""

    last: FloatArray
    velocity: FloatArray
    latest: IntArray
    reports: IntArray
    number: IntArray

    @classmethod
    def none(cls) -> _Alive:
        """No track."""
        nothing = np.zeros(0, dtype=np.int64)
        return cls(np.zeros((0, 2)), np.zeros((0, 2)), nothing, nothing, nothing)

    def which(self, rows: BoolArray) -> _Alive:
        """Some of them."""
        own = (self.latest[rows], self.reports[rows], self.number[rows])
        return _Alive(self.last[rows], self.velocity[rows], *own)

    def move(self, j: IntArray, i: IntArray, time: FloatArray, where: FloatArray) -> None:
        """Go on to reports i with tracks j: smoothed by fixed gains."""
        reports = self.reports[j]
        first = reports == 1
        dt = np.maximum(time[i] - time[self.latest[j]], 1e-3)[:, None]
        found = (where[i] - self.last[j]) / dt
        gain = np.where(first, 1.0, np.maximum(1.0 / reports, 0.2))[:, None]
        predicted = self.last[j] + self.velocity[j] * dt
        smooth = np.where(first, 1.0, 0.6)[:, None]
        self.last[j] = predicted + smooth * (where[i] - predicted)
        self.velocity[j] += gain * (found - self.velocity[j])
        self.latest[j], self.reports[j] = i, reports + 1

    def joined(self, rest: IntArray, number: IntArray, where: FloatArray) -> _Alive:
        """With new tracks of one report each."""
        return _Alive(
            np.concatenate([self.last, where[rest]]),
            np.concatenate([self.velocity, np.zeros((len(rest), 2))]),
            np.concatenate([self.latest, rest]),
            np.concatenate([self.reports, np.ones_like(rest)]),
            np.concatenate([self.number, number]),
        )


def _matched(placed: Placed, setup: Setup, track: IntArray) -> IntArray:
    """One identity for tracks that keep together: the nearest first, one to one at a time."""
    known = np.flatnonzero(track != UNKNOWN)
    order = known[np.lexsort((placed.time[known], track[known]))]
    if not order.size:
        return track
    reports = np.split(order, np.flatnonzero(np.diff(track[order])) + 1)
    sensor = np.array([placed.sensor[own[0]] for own in reports])
    span = np.array([[placed.time[own[0]], placed.time[own[-1]]] for own in reports])
    pairs, gaps, limits = _apart(placed, setup, reports, sensor, span)
    offsets = _provisional(sensor, pairs, gaps, limits)
    away = np.linalg.norm(gaps - offsets, axis=1)
    identity = np.arange(len(reports))
    for k in np.argsort(away, kind="stable"):
        if away[k] > limits[k]:
            break
        a, b = identity[pairs[k]]
        if a == b:
            continue
        one, other = np.flatnonzero(identity == a), np.flatnonzero(identity == b)
        if not _clash(one, other, sensor, span):
            identity[other] = a
    found = np.full(len(track), UNKNOWN)
    found[order] = _renumbered(identity)[track[order]]
    return found


def _apart(
    placed: Placed, setup: Setup, reports: Sequence[IntArray], sensor: IntArray, span: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Pairs of tracks of two sensors, their median gap (vectors), and how far is too far."""
    pairs, gaps, limits = [], [], []
    gate = np.array([np.median(placed.gate[own]) for own in reports])
    order = np.concatenate(reports)
    begin = np.cumsum([0] + [len(own) for own in reports])
    time, where = placed.time[order], placed.spots.where[order]
    for j, own in enumerate(reports):
        late = np.minimum(span[:, 1], span[j, 1]) - np.maximum(span[:, 0], span[j, 0]) > 0.0
        others = np.flatnonzero(late & (sensor < sensor[j]))
        limit = np.hypot(gate[others], gate[j])
        meet = _meet(j, others, begin, time, where, 4.0 * limit, setup.max_speed_m_s)
        mine = placed.spots.take(own)
        for i, most in zip(others[meet].tolist(), limit[meet].tolist(), strict=True):
            other = reports[i]
            spots = placed.spots.take(other)
            at, inside = between(placed.time[other], spots, placed.time[own], placed.window)
            if inside.sum() < _COMMON:
                continue
            gap = np.median((mine.where - at.where)[inside, :2], axis=0)
            high = mine.elsewhere(at)[inside].mean() > 0.5
            if np.linalg.norm(gap) < 2.0 * most and not high:
                pairs.append((i, j))
                gaps.append(gap)
                limits.append(most)
    return (
        np.array(pairs, dtype=np.int64).reshape(-1, 2),
        np.array(gaps, dtype=float).reshape(-1, 2),
        np.array(limits, dtype=float),
    )


@numba.njit(cache=True)
def _meet(
    j: int,
    others: IntArray,
    begin: IntArray,
    time: FloatArray,
    where: FloatArray,
    near: FloatArray,
    speed: float,
) -> BoolArray:
    """Whether track j may be near each other in the middle of their common time."""
    found = np.zeros(len(others), dtype=np.bool_)
    own = time[begin[j] : begin[j + 1]]
    for k in range(len(others)):
        i = others[k]
        other = time[begin[i] : begin[i + 1]]
        middle = 0.5 * (max(own[0], other[0]) + min(own[-1], other[-1]))
        a = begin[j] + min(np.searchsorted(own, middle), len(own) - 1)
        b = begin[i] + min(np.searchsorted(other, middle), len(other) - 1)
        reach = near[k] + speed * abs(time[a] - time[b])
        square = (where[a, 0] - where[b, 0]) ** 2 + (where[a, 1] - where[b, 1]) ** 2
        found[k] = square < reach * reach
    return found


def _provisional(
    sensor: IntArray, pairs: IntArray, gaps: FloatArray, limits: FloatArray
) -> FloatArray:
    """Common displacement (k, d) of two sensors: median gap of tracks nearest to each other."""
    offsets = np.zeros_like(gaps)
    if not len(pairs):
        return offsets
    between = sensor[pairs]
    length = np.linalg.norm(gaps, axis=1)
    for both in np.unique(between, axis=0):
        rows = np.flatnonzero((between == both).all(axis=1))
        rows_in = rows[np.argsort(length[rows])]
        _, first = np.unique(pairs[rows_in, 1], return_index=True)
        nearest = rows_in[first]
        nearest = nearest[length[nearest] < limits[nearest]]
        if nearest.size >= 3:
            offsets[rows] = np.median(gaps[nearest], axis=0)
    return offsets


def _clash(one: IntArray, other: IntArray, sensor: IntArray, span: FloatArray) -> bool:
    """Whether tracks of one sensor in both groups are there at one time."""
    for a in one:
        for b in other[sensor[other] == sensor[a]]:
            common = min(span[a, 1], span[b, 1]) - max(span[a, 0], span[b, 0])
            shorter = min(span[a, 1] - span[a, 0], span[b, 1] - span[b, 0])
            if common > _OVERLAP * shorter:
                return True
    return False


def _renumbered(numbers: IntArray) -> IntArray:
    """Numbers from 0 in place of any, -1 kept."""
    known = numbers != UNKNOWN
    out = np.full(len(numbers), UNKNOWN)
    out[known] = np.unique(numbers[known], return_inverse=True)[1]
    return out
