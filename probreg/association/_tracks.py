"""Tracks of each sensor, and which of them are of one target."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from probreg.association._labelled import _interpolated
from probreg.association._placed import Placed
from probreg.association.nearest_neighbours import assign
from probreg.recordings import UNKNOWN, Recording, Setup
from probreg.typing import FloatArray, IntArray

_LEAST = 4  # reports of a track
_COMMON = 4  # reports at common times that a match needs
_MISSED = 3.0  # scans after which a track ends
_OVERLAP = 0.2  # of the shorter track: two tracks of one sensor are then two targets


def common_tracks(recording: Recording, setup: Setup, placed: Placed) -> IntArray:
    """Identities (n,) by tracks: one number for all tracks that are of one target."""
    track = np.full(len(recording), UNKNOWN)
    for k in np.unique(recording.sensor):
        rows = np.flatnonzero((recording.sensor == k) & np.isfinite(placed.where[:, 0]))
        if not rows.size:
            continue  # bearings have no tracks in the plane
        rows = rows[np.argsort(placed.time[rows], kind="stable")]
        own = link(placed.time[rows], placed.where[rows], placed.gate[rows], setup)
        track[rows[own != UNKNOWN]] = own[own != UNKNOWN] + track.max() + 1
    return _matched(recording, setup, placed, track)


def link(time: FloatArray, where: FloatArray, gate: FloatArray, setup: Setup) -> IntArray:
    """Track number (n,) of one sensor's reports in order of time, -1 for none.

    Reports of half a scan are assigned at once to the tracks predicted with constant velocity
    (`association.assign`); reports left over start tracks; short tracks are given up.
    """
    n = len(time)
    track = np.full(n, UNKNOWN)
    scan = _scan(time, where, setup.max_speed_m_s)
    last, velocity = np.zeros((0, where.shape[1])), np.zeros((0, where.shape[1]))
    seen, count = np.zeros(0), np.zeros(0, dtype=np.int64)
    number = np.zeros(0, dtype=np.int64)
    fresh = 0
    edges = np.searchsorted(time, np.arange(time[0], time[-1] + 0.5 * scan, 0.5 * scan))
    for a, b in zip(edges, [*edges[1:], n], strict=True):
        if a == b:
            continue
        alive = time[a] - seen <= _MISSED * scan
        last, velocity, seen = last[alive], velocity[alive], seen[alive]
        count, number = count[alive], number[alive]
        step = time[a:b, None] - seen[None, :]
        ahead = last[None] + velocity[None] * step[..., None]
        away = np.linalg.norm(where[a:b, None] - ahead, axis=2)
        # a track of one report may go anywhere; prediction errors grow with time
        drift = setup.acceleration_m_s2 * np.sqrt(scan)
        reach = np.where(count == 1, setup.max_speed_m_s, drift) * np.abs(step)
        limit = np.minimum(gate[a:b, None], setup.gate_m) + reach
        pairs = assign((away / limit) ** 2, 1.0) if len(seen) else np.zeros((0, 2), dtype=int)
        i, j = pairs[:, 0], pairs[:, 1]
        track[a + i] = number[j]
        dt = np.maximum(time[a + i] - seen[j], 1e-3)
        found = (where[a + i] - last[j]) / dt[:, None]
        gain = np.where(count[j] == 1, 1.0, np.maximum(1.0 / count[j], 0.2))[:, None]
        predicted = last[j] + velocity[j] * dt[:, None]
        smooth = np.where(count[j] == 1, 1.0, 0.6)[:, None]
        last[j] = predicted + smooth * (where[a + i] - predicted)
        velocity[j] += gain * (found - velocity[j])
        seen[j], count[j] = time[a + i], count[j] + 1
        rest = np.setdiff1d(np.arange(b - a), i) + a
        track[rest] = fresh + np.arange(len(rest))
        number = np.concatenate([number, fresh + np.arange(len(rest))])
        fresh += len(rest)
        last = np.concatenate([last, where[rest]])
        velocity = np.concatenate([velocity, np.zeros((len(rest), where.shape[1]))])
        seen = np.concatenate([seen, time[rest]])
        count = np.concatenate([count, np.ones_like(rest)])
    short = np.bincount(track, minlength=fresh) < _LEAST
    track[short[track]] = UNKNOWN
    return _renumbered(track)


def _scan(time: FloatArray, where: FloatArray, speed: float) -> float:
    """Usual time until a sensor reports a target again, from reports that could be it."""
    gaps = []
    for i in np.unique(np.linspace(0, len(time) - 2, 300).astype(int)):
        step = time[i + 1 : i + 2_000] - time[i]
        away = np.linalg.norm(where[i + 1 : i + 2_000] - where[i], axis=1)
        reach = np.flatnonzero((away < speed * step + 300.0) & (step > 0.0))
        if reach.size:
            gaps.append(step[reach[0]])
    return float(np.median(gaps)) if gaps else float(max(time[-1] - time[0], 1.0))


def _matched(recording: Recording, setup: Setup, placed: Placed, track: IntArray) -> IntArray:
    """One identity for tracks that keep together: the nearest first, one to one at a time."""
    known = np.flatnonzero(track != UNKNOWN)
    order = known[np.lexsort((placed.time[known], track[known]))]
    if not order.size:
        return track
    reports = np.split(order, np.flatnonzero(np.diff(track[order])) + 1)
    sensor = np.array([recording.sensor[own[0]] for own in reports])
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
    for j, own in enumerate(reports):
        late = np.minimum(span[:, 1], span[j, 1]) - np.maximum(span[:, 0], span[j, 0]) > 0.0
        for i in np.flatnonzero(late & (sensor < sensor[j])):
            other, limit = reports[int(i)], float(np.hypot(gate[i], gate[j]))
            if not _meet(placed, own, other, limit, setup.max_speed_m_s):
                continue
            at, inside = _interpolated(
                placed.time[other], placed.where[other], placed.time[own], setup.window_s
            )
            if inside.sum() < _COMMON:
                continue
            gap = np.median((placed.where[own] - at)[inside], axis=0)
            if np.linalg.norm(gap) < 2.0 * limit:
                pairs.append((i, j))
                gaps.append(gap)
                limits.append(limit)
    dim = placed.where.shape[1]
    return (
        np.array(pairs, dtype=np.int64).reshape(-1, 2),
        np.array(gaps, dtype=float).reshape(-1, dim),
        np.array(limits, dtype=float),
    )


def _meet(placed: Placed, one: IntArray, other: IntArray, limit: float, speed: float) -> bool:
    """Whether two tracks may be near each other in the middle of their common time."""
    first, second = placed.time[one], placed.time[other]
    middle = 0.5 * (max(first[0], second[0]) + min(first[-1], second[-1]))
    a = one[min(int(np.searchsorted(first, middle)), len(one) - 1)]
    b = other[min(int(np.searchsorted(second, middle)), len(other) - 1)]
    reach = 4.0 * limit + speed * abs(placed.time[a] - placed.time[b])
    gap = placed.where[a] - placed.where[b]
    return bool(gap @ gap < reach * reach)


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
