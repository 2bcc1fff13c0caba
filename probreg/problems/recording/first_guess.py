"""Where reports place their targets: a guess to linearise at first."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.problems.recording.track_reports import PathPoints, TrackReports
from probreg.typing import FloatArray


def first_guess(reports: TrackReports, height_m: float = 8_000.0) -> PathPoints:
    """Each report where it places its target, others where the nearest in time does.

    Heights of reports without any are those reported nearest in time of the target, else
    `height_m`. A guess to start from: velocities are zero.

    Raises
    ------
    InvalidInputError
        A target that no report places.
    """
    n, d = len(reports), reports.dim
    height = np.full(n, np.nan)
    for k, model in enumerate(reports.models):
        own = np.flatnonzero(reports.sensor == k)
        if len(model.axes.angles) == 1 and model.axes.vertical.all():
            height[own] = reports.values[own, 0]
    height = np.where(np.isnan(height), _nearest(reports, height[:, None])[:, 0], height)
    height = np.where(np.isnan(height), height_m, height)
    position = np.full((n, d), np.nan)
    for k, model in enumerate(reports.models):
        own = np.flatnonzero(reports.sensor == k)
        if own.size:
            position[own] = model.axes.place(reports.reported(own), height[own])
    if reports.own is not None:
        position += reports.own
    position[np.isnan(position).any(axis=1)] = np.nan
    placed = _nearest(reports, position)
    lost = np.flatnonzero(np.isnan(placed).any(axis=1))
    if lost.size:
        raise InvalidInputError(
            f"no report places target {reports.target[lost[0]]}; give a first guess of its path."
        )
    return PathPoints(reports.time, placed, np.zeros((n, d)))


def _nearest(reports: TrackReports, given: FloatArray) -> FloatArray:
    """Rows of `given` (n, k), those of NaN from the nearest in time of the same target."""
    out = given.copy()
    known = np.asarray(~np.isnan(given).any(axis=1))
    order = np.lexsort([reports.time, reports.target])
    place = np.arange(len(order))
    sure = known[order]
    before = np.maximum.accumulate(np.where(sure, place, -1))
    after = np.minimum.accumulate(np.where(sure, place, len(order))[::-1])[::-1]
    target, time = reports.target[order], reports.time[order]
    best, gap = np.full(len(order), -1), np.full(len(order), np.inf)
    for other in (before, after):
        there = (other >= 0) & (other < len(order))
        safe = np.where(there, other, 0)
        away = np.where(there & (target[safe] == target), np.abs(time[safe] - time), np.inf)
        nearer = away < gap
        best[nearer], gap[nearer] = safe[nearer], away[nearer]
    found = (best >= 0) & ~sure
    out[order[found]] = given[order[best[found]]]
    return out
