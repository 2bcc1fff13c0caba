"""Refused reports are offered to the one other target whose smoothed path they fit."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from probreg.motion.tracks import smooth_tracks, with_times
from probreg.posterior.tracks.cavity import Judgement
from probreg.posterior.tracks.model import TrackModel
from probreg.posterior.tracks.steps import Point
from probreg.problems.recording.track_reports import PathPoints, TrackReports
from probreg.typing import BoolArray, FloatArray, IntArray

REFUSED = 0.1  # expected precision below which a report says next to nothing of its target
NEIGHBOUR_S = 12.0  # believed reports of the target on both sides, at most so far away
NEAR_M = 20_000.0  # of where the report itself places its target; biases not yet taken off
FITS, DIFFERS = 16.0, 64.0  # chi-square of the one, and least of every other


class Offer(NamedTuple):
    """Identities after the offer and where every report then stands, in their order."""

    target: IntArray
    path: PathPoints


def offer_refused(
    model: TrackModel, point: Point, path: PathPoints, judged: Judgement, theta: FloatArray
) -> Offer | None:
    """New identities of refused reports that fit one other target; None if there are none.

    Reports that stand beside another go with it, and are not offered by themselves.
    """
    tangent, reports = point.tangent, model.reports
    own, whom = _candidates(model, path, judged.weight[tangent.order])
    if not own.size:
        return None
    finer, place = with_times(tangent.equations, whom, path.time[own])
    motion = model.motion(finer, point.density, point.constant_sd)
    # times without reports have no equations, so weights of equations are as before
    weights = point.weights[tangent.equations.report]
    smoothed = smooth_tracks(finer, motion, weights, theta - tangent.theta, covariance=place)
    assert smoothed.covariance is not None
    mean, covariance = smoothed.mean[place], smoothed.covariance
    best = _one_that_fits(own, _misfit(reports, own, whom, theta, mean, covariance))
    moved = best[whom[best] != reports.target[own[best]]]
    if not moved.size:
        return None
    return _with_companions(reports, path, own[moved], whom[moved], mean[moved])


def _alone(reports: TrackReports) -> BoolArray:
    """Which reports came by themselves."""
    n = len(reports)
    return np.ones(n, dtype=bool) if reports.beside is None else reports.beside == np.arange(n)


def _with_companions(
    reports: TrackReports, path: PathPoints, own: IntArray, whom: IntArray, mean: FloatArray
) -> Offer:
    """Reports `own`, and those beside them, under new identities, at their new states."""
    target, d = reports.target.copy(), reports.dim
    time, position, velocity = (array.copy() for array in path)
    place = np.full(len(target), -1)
    place[own] = np.arange(len(own))
    given = place if reports.beside is None else place[reports.beside]
    moved = np.flatnonzero(given >= 0)
    which = given[moved]
    target[moved] = whom[which]
    time[moved] = path.time[own[which]]
    position[moved], velocity[moved] = mean[which, :d], mean[which, d : 2 * d]
    return Offer(target, PathPoints(time, position, velocity))


def _candidates(
    model: TrackModel, path: PathPoints, weight: FloatArray
) -> tuple[IntArray, IntArray]:
    """Pairs of a refused report and a target that passes near where the report places it."""
    assert model.guess is not None
    refused = np.flatnonzero((weight < REFUSED) & _alone(model.reports))
    believed = np.flatnonzero(weight >= REFUSED)
    believed = believed[np.argsort(path.time[believed], kind="stable")]
    return _near_targets(
        path.time[refused],
        model.guess.position[refused],
        refused,
        (path.time[believed], model.reports.target[believed], path.position[believed]),
        len(model.start),
    )


@numba.njit(cache=True)
def _near_targets(
    time: FloatArray,
    where: FloatArray,
    number: IntArray,
    believed: tuple[FloatArray, IntArray, FloatArray],
    num_targets: int,
) -> tuple[IntArray, IntArray]:
    """For reports (number) at (time, where): targets with believed reports on both sides, near."""
    when, target, position = believed
    row, whom = [np.int64(0) for _ in range(0)], [np.int64(0) for _ in range(0)]
    before, after = np.full(num_targets, -1), np.full(num_targets, -1)
    for i in range(len(time)):
        low = np.searchsorted(when, time[i] - NEIGHBOUR_S)
        high = np.searchsorted(when, time[i] + NEIGHBOUR_S)
        for j in range(low, high):
            if when[j] <= time[i]:
                before[target[j]] = j
            elif after[target[j]] < 0:
                after[target[j]] = j
        for j in range(low, high):
            k = target[j]
            first, last = before[k], after[k]
            if first >= 0 and last >= 0:
                share = (time[i] - when[first]) / (when[last] - when[first])
                away = 0.0
                for a in range(position.shape[1]):
                    here = position[first, a] + share * (position[last, a] - position[first, a])
                    away += (here - where[i, a]) ** 2
                if away < NEAR_M**2:
                    row.append(number[i])
                    whom.append(k)
            before[k], after[k] = -1, -1
    return np.array(row), np.array(whom)


def _misfit(
    reports: TrackReports,
    own: IntArray,
    whom: IntArray,
    theta: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
) -> FloatArray:
    """Chi-square of reports `own` against states of other targets."""
    d = reports.dim
    asked = reports.take(own, np.arange(len(own)))
    time = asked.shifted_time(theta)
    tangent = asked.linearise(theta, PathPoints(time, mean[:, :d], mean[:, d : 2 * d]))
    equations = tangent.equations
    state = np.r_[0:d, 2 * d : mean.shape[1]]
    report = equations.report
    off = equations.y - np.einsum("ed,ed->e", equations.h, mean[:, state][report])
    m = np.diff(equations.report_start)
    at = np.arange(len(off)) - equations.report_start[report]
    C = np.tile(np.eye(m.max()), (len(own), 1, 1))
    a, h = np.zeros((len(own), m.max())), np.zeros((len(own), m.max(), len(state)))
    a[report, at], h[report, at], C[report, at, at] = off, equations.h, equations.variance
    C += h @ covariance[:, state][:, :, state] @ np.swapaxes(h, 1, 2)
    return np.asarray(np.einsum("nm,nm->n", a, np.linalg.solve(C, a[..., None])[..., 0]))


def _one_that_fits(row: IntArray, chi2: FloatArray) -> IntArray:
    """Which pairs are the only ones of their report that fit."""
    order = np.lexsort([chi2, row])
    first = np.flatnonzero(np.diff(row[order], prepend=-1))
    ends = np.append(first[1:], len(order))
    second = np.where(ends > first + 1, chi2[order[np.minimum(first + 1, len(order) - 1)]], np.inf)
    good = (chi2[order[first]] < FITS) & (second > DIFFERS)
    return order[first[good]]
