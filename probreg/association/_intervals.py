"""How often sensors report a target, and so how far apart in time reports can be compared."""

from __future__ import annotations

import numpy as np

from probreg.association.segments import GAP_S
from probreg.recordings import UNKNOWN, Recording, Setup
from probreg.typing import FloatArray

_SCANS = 2.0  # of the slowest sensor: its reports just before and after are then compared
_LEAST_S = 1.0
_NAMED = 0.5  # share of a sensor's reports whose identities tell its interval
_SAMPLES, _AHEAD = 300, 2_000  # reports to start from, and how many after each are looked at
_SLACK_M = 300.0  # a target that stands still moves by its noise


def usual_intervals(recording: Recording, setup: Setup, where: FloatArray) -> FloatArray:
    """Usual times (sensors,) between a sensor's reports of one target, seconds; NaN if unknown.

    They are medians: over the gaps between reports of one track where the sensor's reports
    have identities, else over the times until a report that could be of the same target.

    Parameters
    ----------
    recording : Recording
    setup : Setup
    where : ndarray, shape (n, d)
        Where reports put their targets; NaN where they do not.
    """
    count = len(recording.sensors)
    found = np.full(count, np.nan)
    named = np.flatnonzero(recording.target != UNKNOWN)
    key = recording.target[named] * count + recording.sensor[named]
    order = np.argsort(key, kind="stable")  # in order of time within a target and sensor
    key, time = key[order], recording.time[named[order]]
    gap = np.diff(time)
    same = (np.diff(key) == 0) & (gap > 0.0) & (gap <= GAP_S)
    owner = key[1:] % count
    for k in range(count):
        rows = np.flatnonzero(recording.sensor == k)
        own = gap[same & (owner == k)]
        if own.size and (recording.target[rows] != UNKNOWN).mean() > _NAMED:
            found[k] = np.median(own)
            continue
        rows = rows[np.isfinite(where[rows, 0])]
        if len(rows) > 1:
            found[k] = _scan(recording.time[rows], where[rows, :2], setup.max_speed_m_s)
    return found


def comparison_window(intervals: FloatArray) -> float:
    """Longest time between reports that are compared, seconds.

    Twice the slowest of usual intervals (sensors,), and a second at least.
    """
    known = intervals[np.isfinite(intervals)]
    return max(_LEAST_S, _SCANS * float(known.max(initial=0.0)))


def _scan(time: FloatArray, where: FloatArray, speed: float) -> float:
    """Usual time until a sensor reports a target again, from reports that could be it."""
    gaps = []
    for i in np.unique(np.linspace(0, len(time) - 2, _SAMPLES).astype(int)):
        step = time[i + 1 : i + _AHEAD] - time[i]
        away = np.linalg.norm(where[i + 1 : i + _AHEAD] - where[i], axis=1)
        reach = np.flatnonzero((away < speed * step + _SLACK_M) & (step > 0.0))
        if reach.size:
            gaps.append(step[reach[0]])
    return float(np.median(gaps)) if gaps else np.nan
