"""Steps of the search for a mode: at a tangent until the biases rest, and at the next one."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from probreg.motion.tracks import SmoothedTracks
from probreg.posterior.tracks import steps
from probreg.posterior.tracks.accelerations import fit_acceleration
from probreg.posterior.tracks.cavity import Judgement
from probreg.posterior.tracks.model import TrackModel
from probreg.posterior.tracks.steps import Point, Solution
from probreg.problems.recording.track_reports import PathPoints
from probreg.typing import BoolArray, FloatArray

SETTLED = 0.02  # posterior standard deviations of a last step,
NEARLY = 0.3  # and of one after which tangent or identities change
MOST_STEPS, FULL_STEPS, STALLED = 30, 4, 0.95
LONE_WEIGHT = 1e-5


class Start(NamedTuple):
    """Where to linearise next: all but a tangent, arrays in the order of the recording."""

    theta: FloatArray
    path: PathPoints
    weights: FloatArray
    rest: dict[str, Any]
    steady: PathPoints | None = None

    def point(self, model: TrackModel) -> Point:
        """With the tangent there."""
        tangent = model.reports.linearise(self.theta, self.path, self.steady)
        return Point(tangent, self.weights[tangent.rows], **self.rest)


def with_offer(start: Start, path: PathPoints, moved: BoolArray) -> Start:
    """With a path on which reports that `moved` (n,) stand with other targets."""
    if start.steady is None:
        return start._replace(path=path)
    steady = [np.where(moved if a.ndim == 1 else moved[:, None], a, b)
              for a, b in zip(path, start.steady, strict=True)]  # fmt: skip
    return start._replace(path=path, steady=PathPoints(*steady))


class Search(NamedTuple):
    """Where a search stands: the point after a step, that before it, and what was found there."""

    point: Point
    before: Point
    solution: Solution
    smoothed: SmoothedTracks
    judged: Judgement
    settled: bool = False


def start_of(model: TrackModel, search: Search) -> Start:
    """From the paths that a step has found."""
    point, steady = search.point, None
    if model.reports.varies:
        steady = steps.steady_path(model, search.before, search.solution.theta)
    names = [f.name for f in fields(Point) if f.name not in ("tangent", "weights")]
    return Start(
        search.solution.theta,
        point.tangent.path(search.smoothed.mean),
        point.weights[point.tangent.order],
        {name: getattr(point, name) for name in names},
        steady,
    )


def step(
    model: TrackModel, point: Point, widened: float = 1.0, known: Solution | None = None
) -> Search:
    """Biases unless known, paths, weights; the laws' parameters too if the noise is as it is."""
    solution = steps.solve(model, point) if known is None else known
    constants = model.reports.num_constants > 0
    smoothed = steps.smooth(model, point, solution.theta, covariance=constants)
    judged = steps.judge(model, point, smoothed, widened)
    after = replace(point, spreads=solution.spreads)
    if widened == 1.0 and known is None:
        after = steps.refit(model, after, judged)
        after = steps.refit_constants(model, after, smoothed)
    # reports that no other places must not agree on a path of their own, nor be lost for ever
    lone = np.minimum(judged.weight, LONE_WEIGHT)
    weights = np.where(judged.placed, judged.weight, lone)
    return Search(replace(after, weights=weights), point, solution, smoothed, judged)


def settled(model: TrackModel, start: Start, tangents: int) -> Search:
    """Steps to near rest at the tangent at a path, and again at the paths found there."""
    for again in range(tangents):
        point = fit_acceleration(model, start.point(model), start.theta)
        search = rest(model, point, start.theta, NEARLY)
        del point
        if again + 1 < tangents:
            start = start_of(model, search)
            del search  # room for the next
    return search


def rest(model: TrackModel, point: Point, theta: FloatArray, least: float) -> Search:
    """Steps until the biases stay where they are.

    Reports may hand their weight to and fro for ever: where steps no longer shrink they go half
    way.
    """
    before, half = np.inf, False
    for k in range(MOST_STEPS - 1):
        search = step(model, point)
        sd = np.sqrt(np.diag(search.solution.covariance))
        away = float((np.abs(search.solution.theta - theta) / sd).max(initial=0.0))
        if away < least:
            return search._replace(settled=True)
        half |= k >= FULL_STEPS and away > STALLED * before
        if half:
            weights = 0.5 * (search.before.weights + search.point.weights)
            search = search._replace(point=replace(search.point, weights=weights))
        point, theta, before = search.point, search.solution.theta, away
        del search  # room for the next
    return step(model, point)
