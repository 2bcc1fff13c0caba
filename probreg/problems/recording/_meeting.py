"""Where lines of sight of a target meet, of targets that no single report places."""

from __future__ import annotations

import numpy as np

from probreg.motion.tracks import TrackEquations
from probreg.problems.recording.track_reports import PathPoints, TrackReports
from probreg.typing import FloatArray

MOST = 60  # reports that are enough
WINDOW_S = 20.0  # within which a target is held to stand still at first
REACH_M, POINTS = 300_000.0, 41  # of the grid of places to start from, points a side
STARTS = 5
STEPS = 25
ACROSS_M_S, UP_M, UP_M_S = 350.0, 5_000.0, 50.0  # standard deviations of prior beliefs
LOOSE = 3.0  # times the noise, as sensors have biases
SURE_M = 10_000.0  # standard deviation of a place above which lines do not meet


def meeting_path(reports: TrackReports, centre: FloatArray) -> FloatArray | None:
    """Positions (n, d) of a target at its reports, on a straight path; None if they do not say.

    `centre` (d,) is where to look first, its height where the target is held to fly.
    """
    some = np.unique(np.linspace(0, len(reports) - 1, MOST).astype(int))
    some = np.argsort(reports.time, kind="stable")[some]
    part = reports.take(some, np.zeros(len(some), dtype=int))
    middle = part.time[len(some) // 2]
    since = part.time - middle
    best: tuple[float, FloatArray, FloatArray] = np.inf, np.zeros(0), np.zeros((0, 0))
    for start in _starts(part, np.abs(since) <= WINDOW_S, centre):
        found = _straight(part, since, start, centre)
        if found[0] < best[0]:
            best = found
    level = min(2, reports.dim)
    _, state, covariance = best
    if not np.isfinite(best[0]) or np.trace(covariance[:level, :level]) > SURE_M**2:
        return None
    return _along(state, reports.time - middle)


def _along(state: FloatArray, since: FloatArray) -> FloatArray:
    """Positions (n, d) of a straight path."""
    d = len(state) // 2
    return np.asarray(state[:d] + since[:, None] * state[d:])


def _equations(reports: TrackReports, position: FloatArray) -> TrackEquations:
    """At positions of one target, in order of time; biases are zero."""
    still = PathPoints(reports.time, position, np.zeros_like(position))
    return reports.linearise(np.zeros(reports.num_biases), still).equations


def _starts(part: TrackReports, near: FloatArray, centre: FloatArray) -> list[FloatArray]:
    """The places of a grid that the reports of a short time fit best."""
    side = np.linspace(-REACH_M, REACH_M, POINTS)
    grid = np.tile(centre, (POINTS**2, 1))
    grid[:, :2] += np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    rows = np.flatnonzero(near)
    every = part.take(np.tile(rows, len(grid)), np.repeat(np.arange(len(grid)), len(rows)))
    position = np.repeat(grid, len(rows), axis=0)
    found = _equations(every, position)
    off = found.y - np.einsum("ed,ed->e", found.h, position[found.report])
    cost = np.log1p(off**2 / (LOOSE**2 * found.variance))
    total = np.bincount(found.target[found.report], cost, len(grid))
    return list(grid[np.argsort(total, kind="stable")[:STARTS]])


def _straight(
    part: TrackReports, since: FloatArray, start: FloatArray, centre: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """A straight path by Gauss and Newton: cost, state (2 d,), covariance."""
    d = len(start)
    state = np.concatenate([start, np.zeros(d)])
    about = np.concatenate([centre, np.zeros(d)])
    sd = np.concatenate([[REACH_M] * 2, [UP_M] * (d - 2), [ACROSS_M_S] * 2, [UP_M_S] * (d - 2)])
    for _ in range(STEPS):
        position = _along(state, since)
        found = _equations(part, position)
        report = found.report
        off = found.y - np.einsum("ed,ed->e", found.h, position[report])
        square = off**2 / (LOOSE**2 * found.variance)
        weight = 1.0 / (LOOSE**2 * found.variance * (1.0 + square))
        H = np.hstack([found.h, since[report][:, None] * found.h])
        precision = H.T @ (weight[:, None] * H) + np.diag(sd**-2.0)
        pull = H.T @ (weight * off) + (about - state) / sd**2
        cost = float(np.log1p(square).sum() + (((state - about) / sd) ** 2).sum())
        state = state + np.linalg.solve(precision, pull)
    return cost, state, np.linalg.inv(precision)
