"""Gibbs sampling of whole recordings: the biases with the paths integrated out, then the rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from probreg.motion.tracks import SmoothedTracks, draw_tracks
from probreg.posterior.tracks import Judgement, Point, Solution, TrackFit, TrackModel, solve
from probreg.posterior.tracks.accelerations import by_level, level_targets, log_prior, paths_at
from probreg.posterior.tracks.cavity import room_for
from probreg.posterior.tracks.drift_draws import draw_precisions, draw_spreads
from probreg.posterior.tracks.drifting import coefficients
from probreg.posterior.tracks.steps import (
    CONSTANT_TARGETS,
    WRONG_ROWS,
    constant_square,
    counts_of,
    evidence_of,
    judge,
)
from probreg.samplers.tracks._draws import TrackDraws
from probreg.typing import FloatArray
from probreg.validation import sampling_run

STEP = 2.4  # of the acceleration's logarithm, in its own standard deviations


class _Sweep(NamedTuple):
    """What one sweep leaves."""

    point: Point
    solution: Solution
    theta: FloatArray
    states: FloatArray
    drawn: Judgement


@dataclass(frozen=True)
class GibbsTracks:
    """Draw biases, paths, precisions, identities, laws, shares and accelerations in turn.

    The acceleration is drawn with paths and biases integrated out, the biases with the paths
    integrated out, all at the tangent of the fit. Of biases that drift the spreads are drawn too,
    and whole paths.

    Parameters
    ----------
    warmup : int
        Sweeps that are not kept, from the mode.
    """

    warmup: int = 10

    def sample(
        self, fit: TrackFit, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> TrackDraws:
        """Run chains from the mode.

        Parameters
        ----------
        fit : TrackFit
        num_draws, num_chains : int
            Sweeps kept of each chain; chains.
        rng : numpy.random.Generator

        Returns
        -------
        TrackDraws

        Raises
        ------
        InvalidInputError
            Numbers below one, no generator.
        """
        sampling_run(num_draws, num_chains, rng)
        step = STEP * _acceleration_sd(fit)
        kept: list[list[_Sweep]] = []
        means = np.zeros_like(fit.mean), np.zeros_like(fit.wrong), np.zeros_like(fit.wrong)
        for _ in range(num_chains):
            point, chain = fit.point, []
            for k in range(self.warmup + num_draws):
                sweep = _sweep(fit.model, point, step, rng)
                point = sweep.point
                if k >= self.warmup:
                    chain.append(sweep._replace(states=np.zeros(0), drawn=_NO_REPORTS))
                    seen = (sweep.states, sweep.drawn.wrong, _outlier(sweep.drawn))
                    for total, one in zip(means, seen, strict=True):
                        total += one / (num_draws * num_chains)
            kept.append(chain)
        return _gathered(fit, kept, means)


def _sweep(model: TrackModel, point: Point, step: float, rng: np.random.Generator) -> _Sweep:
    """One draw of everything."""
    point, solution = _acceleration(model, point, step, rng)
    point, solution, theta = _biases(model, point, solution, rng)
    point = _levels(model, point, theta, rng)
    equations = point.tangent.equations
    motion = model.motion(equations, point.density, point.constant_sd)
    paths = draw_tracks(equations, motion, rng, point.weights, theta - point.tangent.theta)
    drawn = _which(model, point, paths, rng)
    point = replace(point, weights=drawn.weight)
    return _Sweep(_parameters(model, point, paths, drawn, rng), solution, theta, paths.mean, drawn)


def _biases(
    model: TrackModel, point: Point, solution: Solution, rng: np.random.Generator
) -> tuple[Point, Solution, FloatArray]:
    """Draw the biases; of those that drift first the spreads, and then whole paths."""
    if model.drift is None:
        p = len(solution.theta)
        root = np.linalg.cholesky(solution.covariance)
        return point, solution, solution.theta + root @ rng.standard_normal(p)
    assert solution.spreads is not None
    evidence = evidence_of(model, solution.information, point.tangent.theta)
    spreads, _ = draw_spreads(model.drift, evidence, solution.spreads, rng)
    found = coefficients(model.drift, evidence, spreads)
    theta = found.draw(rng, 1)[0]
    point = replace(point, spreads=draw_precisions(model.drift, spreads, theta, rng))
    return point, solution._replace(theta=found.mean, covariance=found.covariance), theta


def _acceleration(
    model: TrackModel, point: Point, step: float, rng: np.random.Generator
) -> tuple[Point, Solution]:
    """A Metropolis step of the acceleration's logarithm, biases and paths integrated out."""
    if step == 0.0:
        return point, solve(model, point, given=True)
    # the acceleration is drawn from what it is, whatever biases are solved under
    here = solve(model, point, 1.0, given=True)
    moved = replace(point, q=float(point.q * np.exp(step * rng.standard_normal())))
    there = solve(model, moved, 1.0, given=True)
    gain = there.log_marginal - here.log_marginal
    gain += log_prior(model, np.log(moved.q)) - log_prior(model, np.log(point.q))
    point, found = (moved, there) if np.log(rng.random()) < gain else (point, here)
    return point, found if model.caution == 1.0 else solve(model, point, given=True)


def _levels(model: TrackModel, point: Point, theta: FloatArray, rng: np.random.Generator) -> Point:
    """Draw each target's level of acceleration given the biases, paths integrated out; shares."""
    if model.acceleration_log_sd == 0.0 or len(model.levels) == 1:
        return point
    assert point.shares is not None
    odds = by_level(model, paths_at(model, point, theta), point.q) + np.log(point.shares)
    total = np.cumsum(np.exp(odds - odds.max(axis=1, keepdims=True)), axis=1)
    which = (total < rng.random((len(total), 1)) * total[:, -1:]).sum(axis=1)
    counts = np.bincount(which, minlength=len(model.levels))
    shares = rng.dirichlet(counts + level_targets(model))
    return replace(point, livelier=np.asarray(model.levels)[which], shares=shares)


def _acceleration_sd(fit: TrackFit) -> float:
    """Of the acceleration's logarithm, from the curvature at the mode."""
    model, point = fit.model, fit.point
    if model.acceleration_log_sd == 0.0:
        return 0.0
    width = 0.2
    heights = []
    for side in (-1.0, 0.0, 1.0):
        moved = replace(point, q=float(point.q * np.exp(side * width)))
        solution = solve(model, moved, 1.0, given=True)
        heights.append(solution.log_marginal + log_prior(model, np.log(moved.q)))
    bend = (2.0 * heights[1] - heights[0] - heights[2]) / width**2
    return float(1.0 / np.sqrt(max(bend, model.acceleration_log_sd**-2)))


def _which(
    model: TrackModel, point: Point, paths: SmoothedTracks, rng: np.random.Generator
) -> Judgement:
    """Draw which Gaussian, or none, each report is of, given its noise."""
    width = int(np.diff(point.tangent.equations.report_start).max())
    exact = replace(paths, spread=np.zeros((len(paths.residual), width)))
    judged = judge(model, point, exact)
    n, J = judged.probability.shape
    total = np.cumsum(np.column_stack([judged.probability, judged.wrong]), axis=1)
    which = (total < rng.random((n, 1)) * total[:, -1:]).sum(axis=1)
    one = np.zeros((n, J + 1))
    one[np.arange(n), which] = 1.0
    variance = model.mixtures(point.tangent, point.laws, point.wrong)
    precision = np.column_stack([1.0 / variance.variance[variance.sensor], np.zeros(n)])
    return judged._replace(
        probability=one[:, :J], wrong=one[:, J], weight=precision[np.arange(n), which]
    )


def _parameters(
    model: TrackModel,
    point: Point,
    paths: SmoothedTracks,
    drawn: Judgement,
    rng: np.random.Generator,
) -> Point:
    """Draw the laws' parameters, the shares of wrong identities and the spread of constants."""
    laws, wrong = list(point.laws), point.wrong.copy()
    there = np.diff(point.tangent.equations.report_start) > 0
    assert model.unknown is not None
    for s, law in enumerate(point.laws):
        counts, missed, n = counts_of(model, point, drawn, s, there)
        m = len(model.reports.models[s].sigmas)
        laws[s] = law.draw_parameters(rng, counts, m, model.unknown[s], model.laws[s])
        if wrong[s] > 0.0:
            prior = WRONG_ROWS * model.wrong_shares[s]
            wrong[s] = rng.beta(missed + prior, n - missed + WRONG_ROWS - prior)
    spread = point.constant_sd
    if model.reports.num_constants:
        square, K = constant_square(model, point, paths)
        about = CONSTANT_TARGETS * np.asarray(model.constant_sd) ** 2
        drawn_sd = np.sqrt((square + about) / rng.chisquare(K + CONSTANT_TARGETS, len(square)))
        spread = np.where(model.constant_known, model.constant_sd, drawn_sd)
    return replace(point, laws=tuple(laws), wrong=wrong, constant_sd=spread)


def _outlier(drawn: Judgement) -> FloatArray:
    return np.asarray(1.0 - drawn.wrong - drawn.probability[:, 0])


def _gathered(
    fit: TrackFit,
    kept: list[list[_Sweep]],
    means: tuple[FloatArray, FloatArray, FloatArray],
) -> TrackDraws:
    order = fit.point.tangent.order
    states, wrong, outlier = means
    return TrackDraws(
        theta=np.array([[s.theta for s in chain] for chain in kept]),
        conditional_mean=np.array([[s.solution.theta for s in chain] for chain in kept]),
        conditional_covariance=np.array([[s.solution.covariance for s in chain] for chain in kept]),
        acceleration=np.array([[s.point.q for s in chain] for chain in kept]),
        constant_sd=np.array([[s.point.constant_sd for s in chain] for chain in kept]),
        wrong_share=np.array([[s.point.wrong for s in chain] for chain in kept]),
        laws=tuple(tuple(s.point.laws for s in chain) for chain in kept),
        wrong=wrong[order],
        outlier=outlier[order],
        mean_state=states[order],
    )


_NO_REPORTS = room_for(0, 0)
