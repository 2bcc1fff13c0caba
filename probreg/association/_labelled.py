"""Reports without identity, given to targets that other reports identify."""

from __future__ import annotations

import numpy as np

from probreg.association._placed import Placed
from probreg.association._spots import between
from probreg.recordings import UNKNOWN
from probreg.typing import FloatArray, IntArray

_SAME_SCAN = 0.5  # of a sensor's usual time between reports of a target


def nearest_labelled(placed: Placed, labelled: IntArray) -> IntArray:
    """Identities (n,): unlabelled reports take the nearest labelled target at their time.

    A target is where its labelled reports, interpolated, put it; it is nowhere in gaps longer
    than the window. A sensor reports a target once a scan: of two reports nearer in time than
    half its usual interval the nearer one in space is taken.
    """
    target = labelled.copy()
    missing = np.flatnonzero((target == UNKNOWN) & placed.judged)
    best, distance = np.full(len(missing), UNKNOWN), np.ones(len(missing))
    time, window = placed.time[missing], placed.window
    order = np.argsort(time, kind="stable")
    known = np.flatnonzero((target != UNKNOWN) & np.isfinite(placed.spots.where[:, 0]))
    known = known[np.lexsort((placed.time[known], target[known]))]
    for own in np.split(known, np.flatnonzero(np.diff(target[known])) + 1):
        # only the reports within the target's own times
        a = np.searchsorted(time[order], placed.time[own[0]] - 0.5 * window)
        b = np.searchsorted(time[order], placed.time[own[-1]] + 0.5 * window)
        rows = order[a:b]
        spots, near = between(placed.time[own], placed.spots.take(own), time[rows], window)
        away = placed.misfit(missing[rows], spots)
        nearer = near & (away < distance[rows])
        best[rows[nearer]], distance[rows[nearer]] = target[own[0]], away[nearer]
    once = _once_a_scan(placed.sensor[missing], best, time, distance)
    target[missing[once]] = best[once]
    return target


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
