"""Accelerations of targets: one density, and groups that have several times as much."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from probreg.motion.tracks import TrackEquations, TrackMotion, eliminate_paths, spans
from probreg.posterior.tracks.model import TrackModel
from probreg.posterior.tracks.steps import MANY_REPORTS, Point, some_targets
from probreg.typing import FloatArray, IntArray

GRID = float(np.log(3.0))  # of the density's logarithm
REACH = 4.0  # standard deviations of the prior
# targets that the prior share of each level counts for: the first, all others together
USUAL_TARGETS, LIVELY_TARGETS = 8.0, 2.0
SHARE_STEPS = 20


class Paths(NamedTuple):
    """Reports of targets at given biases, and how they move but for the density."""

    equations: TrackEquations
    motion: TrackMotion
    weights: FloatArray

    def of_targets(self, among: IntArray | None) -> Paths:
        """Some targets' reports; all if none are named."""
        if among is None:
            return self
        rows = spans(self.equations.target_start, among)
        motion = TrackMotion(*(array[among] for array in self.motion))
        return Paths(self.equations.of_targets(among), motion, self.weights[rows])

    def log_likelihood(self, q: float | FloatArray) -> FloatArray:
        """Of each target, shape (K,), at a density of its acceleration, its path integrated out."""
        density = np.array(np.broadcast_to(q, self.motion.q.shape), dtype=float)
        motion = self.motion._replace(q=density)
        return eliminate_paths(self.equations, motion, 0, self.weights).log_likelihood_by_target


def paths_at(model: TrackModel, point: Point, theta: FloatArray) -> Paths:
    """Reports with the biases theta taken off."""
    equations = point.tangent.equations
    motion = model.motion(equations, point.density, point.constant_sd)
    y = equations.minus_biases(theta - point.tangent.theta)
    none = np.zeros((len(y), 0))
    clean = equations._replace(y=y, column=none.astype(np.int64), response=none)
    return Paths(clean, motion, point.weights)


def level_targets(model: TrackModel) -> FloatArray:
    """How many targets the prior share of each level counts for, shape (L,)."""
    others = len(model.levels) - 1
    return np.array([USUAL_TARGETS, *[LIVELY_TARGETS / max(others, 1)] * others])


def by_level(model: TrackModel, paths: Paths, q: float) -> FloatArray:
    """Log likelihood of each target at each level of the density q, shape (K, L)."""
    return np.column_stack([paths.log_likelihood(q * level) for level in model.levels])


def fit_acceleration(model: TrackModel, point: Point, theta: FloatArray) -> Point:
    """The density with the highest posterior given weights and biases, and each target's level.

    The density and the shares of levels are found from at most some 20 000 reports, which settle
    them to a few per cent.
    """
    if model.acceleration_log_sd == 0.0:
        return replace(point, q=model.acceleration)
    paths = paths_at(model, point, theta)
    count = np.diff(paths.equations.target_start)
    some = paths.of_targets(some_targets(count, MANY_REPORTS))
    log_q, shares = _on_grid(model, some, None if point.shares is None else np.log(point.q))
    own = _levels(model, some, float(np.exp(log_q)), shares)

    def loss(x: float) -> float:
        return -log_prior(model, x) - float(some.log_likelihood(np.exp(x) * own).sum())

    bounds = np.clip([log_q - GRID, log_q + GRID], *_limits(model))
    found = minimize_scalar(loss, bounds=bounds, method="bounded", options={"xatol": 0.01})
    q = float(np.exp(found.x))
    return replace(point, q=q, livelier=_levels(model, paths, q, shares), shares=shares)


def _levels(model: TrackModel, paths: Paths, q: float, shares: FloatArray) -> FloatArray:
    """The most probable level of each target, shape (K,)."""
    odds = by_level(model, paths, q) + np.log(shares)
    return np.asarray(model.levels)[np.argmax(odds, axis=1)]


def _limits(model: TrackModel) -> tuple[float, float]:
    middle, reach = float(np.log(model.acceleration)), REACH * model.acceleration_log_sd
    return middle - reach, middle + reach


def log_prior(model: TrackModel, log_q: float) -> float:
    """Of the density's logarithm, up to a constant."""
    z = (log_q - np.log(model.acceleration)) / model.acceleration_log_sd
    return float(-0.5 * z**2)


def _on_grid(model: TrackModel, some: Paths, near: float | None) -> tuple[float, FloatArray]:
    """Density and shares of levels with the highest posterior of a grid, in the logarithm.

    Of the whole prior, or of the neighbours of `near`.
    """
    low, high = _limits(model)
    middle = 0.5 * (low + high)
    steps = int((high - middle) / GRID)
    grid = middle + GRID * np.arange(-steps, steps + 1)
    if near is not None:
        grid = np.clip(near + GRID * np.arange(-1, 2), low, high)
    known: dict[float, FloatArray] = {}
    best: tuple[float, float, FloatArray] = -np.inf, middle, np.ones(1)
    for log_q in grid:
        at = [log_q + np.log(level) for level in model.levels]
        for x in at:
            if round(x, 6) not in known:
                known[round(x, 6)] = some.log_likelihood(np.exp(x))
        height, shares = _shares(model, np.column_stack([known[round(x, 6)] for x in at]))
        height += log_prior(model, log_q)
        if height > best[0]:
            best = height, float(log_q), shares
    return best[1], best[2]


def _shares(model: TrackModel, density: FloatArray) -> tuple[float, FloatArray]:
    """Log posterior and shares of levels whose log likelihoods are `density` (K, L), by EM."""
    prior = level_targets(model)
    total, shares = prior.sum() + len(density), prior / prior.sum()
    for _ in range(SHARE_STEPS):
        odds = density + np.log(shares)
        top = odds.max(axis=1, keepdims=True)
        p = np.exp(odds - top)
        whole = p.sum(axis=1, keepdims=True)
        height = float((top + np.log(whole)).sum() + prior @ np.log(shares))
        shares = ((p / whole).sum(axis=0) + prior) / total
    return height, shares
