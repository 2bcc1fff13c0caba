"""Reports without identity, given to targets that other reports identify."""

from __future__ import annotations

import numpy as np

from probreg.association._placed import Placed
from probreg.recordings import UNKNOWN, Recording, Setup
from probreg.typing import BoolArray, FloatArray, IntArray

_SAME_SCAN = 0.5  # of a sensor's usual time between reports of a target


def nearest_labelled(
    recording: Recording, setup: Setup, placed: Placed, labelled: IntArray
) -> IntArray:
    """Identities (n,): unlabelled reports take the nearest labelled target at their time.

    A target is where its labelled reports, interpolated, put it; it is nowhere in gaps longer
    than the window. A sensor reports a target once a scan: of two reports nearer in time than
    half its usual interval the nearer one in space is taken.
    """
    target = labelled.copy()
    missing = np.flatnonzero(target == UNKNOWN)
    best, distance = np.full(len(missing), UNKNOWN), np.ones(len(missing))
    time = placed.time[missing]
    order = np.argsort(time, kind="stable")
    known = np.flatnonzero((target != UNKNOWN) & np.isfinite(placed.where[:, 0]))
    known = known[np.lexsort((placed.time[known], target[known]))]
    for own in np.split(known, np.flatnonzero(np.diff(target[known])) + 1):
        # only the reports within the target's own times
        a = np.searchsorted(time[order], placed.time[own[0]] - 0.5 * setup.window_s)
        b = np.searchsorted(time[order], placed.time[own[-1]] + 0.5 * setup.window_s)
        rows = order[a:b]
        where, near = _interpolated(placed.time[own], placed.where[own], time[rows], setup.window_s)
        away = placed.misfit(missing[rows], where)
        nearer = near & (away < distance[rows])
        best[rows[nearer]], distance[rows[nearer]] = target[own[0]], away[nearer]
    once = _once_a_scan(recording.sensor[missing], best, time, distance)
    target[missing[once]] = best[once]
    return target


def _interpolated(
    time: FloatArray, where: FloatArray, at: FloatArray, window: float
) -> tuple[FloatArray, BoolArray]:
    """Positions (k, d) of a target at other times, and whether a report is near enough."""
    after = np.clip(np.searchsorted(time, at), 1, max(len(time) - 1, 1))
    if len(time) == 1:
        return np.repeat(where, len(at), axis=0), np.abs(at - time[0]) <= 0.1 * window
    gap = time[after] - time[after - 1]
    share = (at - time[after - 1]) / np.where(gap > 0.0, gap, 1.0)
    inside = (share >= -0.1) & (share <= 1.1) & (gap <= 3.0 * window)
    step = where[after] - where[after - 1]
    return where[after - 1] + share[:, None] * step, inside


def _once_a_scan(
    sensor: IntArray, target: IntArray, time: FloatArray, distance: FloatArray
) -> IntArray:
    """Numbers of the reports that keep their target: one a scan of each sensor."""
    chosen = np.flatnonzero(target != UNKNOWN)
    order = chosen[np.lexsort((time[chosen], target[chosen], sensor[chosen]))]
    same = (np.diff(sensor[order]) == 0) & (np.diff(target[order]) == 0)
    gap = np.diff(time[order])
    keep = np.ones(len(order), dtype=bool)
    for k in np.unique(sensor[order]):
        own = same & (sensor[order][1:] == k)
        if not own.any():
            continue
        close = np.flatnonzero(own & (gap < _SAME_SCAN * np.median(gap[own])))
        worse = np.where(distance[order[close]] > distance[order[close + 1]], close, close + 1)
        keep[worse] = False
    return order[keep]
