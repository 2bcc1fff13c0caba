"""Where reports place their targets: a guess to linearise at first."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.problems.recording._meeting import meeting_path
from probreg.problems.recording.track_reports import PathPoints, TrackReports
from probreg.typing import FloatArray


def first_guess(
    reports: TrackReports, height_m: float = 8_000.0, *, strict: bool = True
) -> PathPoints:
    """Each report where it places its target, others where the nearest in time does.

    Heights of reports without any are those reported nearest in time of the target, else
    `height_m`. Targets that no report places are where their lines of sight meet. A guess to
    start from: velocities are zero.

    Parameters
    ----------
    reports : TrackReports
    height_m : float
    strict : bool
        Whether a target that reports do not place at all is an error; else its positions are
        NaN.

    Raises
    ------
    InvalidInputError
        A target that no report places, and whose lines of sight do not meet.
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
    _meet(reports, placed, height)
    lost = np.unique(reports.target[np.isnan(placed).any(axis=1)])
    if lost.size and strict:
        raise InvalidInputError(
            f"no report places target {lost[0]} ({lost.size} in all), and its lines of sight do "
            "not meet; leave it out or give a first guess of its path."
        )
    return PathPoints(reports.time, placed, np.zeros((n, d)))


def _meet(reports: TrackReports, placed: FloatArray, height: FloatArray) -> None:
    """Place targets that are nowhere yet where their lines of sight meet, if they do."""
    nowhere = np.isnan(placed).any(axis=1)
    if not nowhere.any():
        return
    centre = np.zeros(reports.dim)
    if not nowhere.all():
        centre = np.median(placed[~nowhere], axis=0)
    for k in np.unique(reports.target[nowhere]):
        own = np.flatnonzero(reports.target == k)
        centre[2:] = np.median(height[own])
        found = meeting_path(reports.take(own), centre)
        if found is not None:
            placed[own] = found


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
