"""Single steps towards the mode: solve for the biases, smooth, judge reports, refit the rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from probreg.motion.tracks import (
    LEAST_WEIGHT,
    BiasInformation,
    DriftInformation,
    SmoothedTracks,
    TrackEquations,
    TrackMotion,
    eliminate_drifting,
    eliminate_paths,
    smooth_tracks,
)
from probreg.noise import MixtureCounts, ScaleMixture
from probreg.posterior.tracks.cavity import Judgement, judge_reports, room_for
from probreg.posterior.tracks.drifting import Evidence, Spreads, coefficients, fit_spreads
from probreg.posterior.tracks.model import WIDEST_M, TrackModel
from probreg.problems.recording.knots import Knots
from probreg.problems.recording.track_reports import PathPoints, TrackLinearisation
from probreg.typing import BoolArray, FloatArray, IntArray

MANY_REPORTS = 20_000  # enough for what a few parameters need
# of the acceleration: whitened noise of a path falls with the power 5/4 of it
STEADY = 0.01
WRONG_ROWS = 10.0  # reports that the prior share of wrong identities counts for
CONSTANT_TARGETS = 2.0  # targets that the prior spread of their constants counts for


@dataclass(frozen=True, eq=False)
class Point:
    """Where the search stands; arrays of reports are in the order of the tangent.

    Attributes
    ----------
    tangent : TrackLinearisation
    weights : ndarray, shape (n,)
    q : float
    laws : tuple of ScaleMixture
    wrong : ndarray, shape (sensors,)
    constant_sd : ndarray, shape (c,)
    livelier : float or ndarray, shape (K,)
        How many times q the acceleration of each target has.
    shares : ndarray, shape (L,)
        Of targets at each of the model's levels of acceleration.
    spreads : Spreads or None
        Of biases that drift, where the search for theirs begins.
    """

    tangent: TrackLinearisation
    weights: FloatArray
    q: float
    laws: tuple[ScaleMixture, ...]
    wrong: FloatArray
    constant_sd: FloatArray
    livelier: float | FloatArray = 1.0
    shares: FloatArray | None = None
    spreads: Spreads | None = None

    @property
    def density(self) -> FloatArray:
        """Of the acceleration, of each target or of all."""
        return np.asarray(self.q * self.livelier)


Information = BiasInformation | DriftInformation


class Solution(NamedTuple):
    """Biases given the weights.

    Attributes
    ----------
    theta : ndarray, shape (P,)
    covariance : ndarray, shape (P, P)
    information : BiasInformation or DriftInformation
    log_marginal : float
        Log density of the reports given weights and accelerations, paths and biases
        integrated out.
    spreads : Spreads or None
        Of biases that drift, the most probable ones.
    """

    theta: FloatArray
    covariance: FloatArray
    information: Information
    log_marginal: float
    spreads: Spreads | None = None


def solve(model: TrackModel, point: Point, caution: float | None = None) -> Solution:
    """Biases at which the posterior given the weights is highest; exact but for the tangent.

    `caution` is by default the model's.
    """
    equations = point.tangent.equations
    density = point.density * (model.caution if caution is None else caution)
    motion = model.motion(equations, density, point.constant_sd)
    found = information_of(model.reports.coefficients, equations, motion, point.weights)
    if model.drift is not None:
        return _solve_drifting(model, point, found)
    J, eta = _without_common_clock(model, found)
    prior = np.linalg.inv(model.prior.covariance)
    away = model.prior.mean - point.tangent.theta
    total, pull = J + prior, eta + prior @ away
    covariance = np.linalg.inv(total)
    delta = covariance @ pull
    log_marginal = found.log_likelihood + 0.5 * (
        pull @ delta
        - away @ prior @ away
        + np.linalg.slogdet(prior)[1]
        - np.linalg.slogdet(total)[1]
    )
    return Solution(point.tangent.theta + delta, covariance, found, float(log_marginal))


def information_of(
    knots: Knots, equations: TrackEquations, motion: TrackMotion, weights: FloatArray
) -> Information:
    """What reports say of all coefficients, the paths integrated out."""
    if not knots.drifting:
        return eliminate_paths(equations, motion, knots.num_biases, weights)
    columns = knots.num_static, len(knots.drifting)
    return eliminate_drifting(equations, motion, columns, knots.time, weights)


def _without_common_clock(model: TrackModel, found: Information) -> tuple[FloatArray, FloatArray]:
    """Precision and shift without a common shift of all clocks, whatever the tangent claims."""
    J, eta = found.precision, found.shift
    together = model.all_clocks
    if together is not None:
        free = np.eye(len(eta)) - np.outer(together, together)
        J, eta = free @ J @ free, free @ eta
    return J, eta


def evidence_of(model: TrackModel, found: Information, theta: FloatArray) -> Evidence:
    """What reports say of coefficients that drift, from information about those from theta on."""
    assert model.drift is not None
    J, eta = _without_common_clock(model, found)
    return Evidence.at(model.drift, J, eta, theta, found.log_likelihood)


def _solve_drifting(model: TrackModel, point: Point, found: Information) -> Solution:
    """Coefficients at the most probable spreads."""
    assert model.drift is not None
    evidence = evidence_of(model, found, point.tangent.theta)
    spreads = fit_spreads(model.drift, evidence, point.spreads)
    best = coefficients(model.drift, evidence, spreads)
    return Solution(best.mean, best.covariance, found, best.log_marginal, spreads)


def smooth(
    model: TrackModel, point: Point, theta: FloatArray, covariance: bool = False
) -> SmoothedTracks:
    """Paths given weights and biases."""
    equations = point.tangent.equations
    motion = model.motion(equations, point.density, point.constant_sd)
    delta = theta - point.tangent.theta
    return smooth_tracks(
        equations, motion, point.weights, delta, covariance=covariance, spread=True
    )


def steady_path(model: TrackModel, point: Point, theta: FloatArray) -> PathPoints:
    """Paths for the columns of terms: smoother than those that reports are compared with.

    A path follows its reports' noise. A column that is of the path, such as a share of its height,
    then answers to the noise as the equations do, and biases the estimate: in whitened form both
    consist of little else.
    """
    found = smooth(model, replace(point, q=STEADY * point.q), theta)
    return point.tangent.path(found.mean)


def judge(
    model: TrackModel, point: Point, smoothed: SmoothedTracks, widened: float = 1.0
) -> Judgement:
    """What each report is, given all others."""
    equations = point.tangent.equations
    mixtures = model.mixtures(point.tangent, point.laws, point.wrong, widened)
    out = room_for(len(equations.time), mixtures.variance.shape[1])
    assert smoothed.spread is not None
    there = np.where(point.weights < LEAST_WEIGHT, 0.0, point.weights)
    found = smoothed.residual, smoothed.spread
    judge_reports(equations, found, there, mixtures, WIDEST_M * widened, out)
    return out


def counts_of(
    model: TrackModel, point: Point, judged: Judgement, s: int, among: BoolArray
) -> tuple[MixtureCounts, float, int]:
    """Of sensor s: counts of its law's Gaussians, of wrong identities, and of its reports.

    `among` (n,) says which reports count.
    """
    own = np.flatnonzero((model.reports.sensor[point.tangent.rows] == s) & among)
    size = np.diff(point.tangent.equations.report_start)[own]
    J = len(point.laws[s].mixture(len(model.reports.models[s].sigmas)).share)
    p = judged.probability[own, :J]
    square = np.einsum("nj,nj->j", p, judged.square[own, :J])
    counts = MixtureCounts(p.sum(axis=0), size @ p, square)
    return counts, float(judged.wrong[own].sum()), len(own)


def refit(model: TrackModel, point: Point, judged: Judgement) -> Point:
    """The parameters of the laws and the shares of wrong identities by expected counts.

    Reports that no other places stay out of them: they fit any scale.
    """
    laws, wrong = list(point.laws), point.wrong.copy()
    assert model.unknown is not None
    for s, law in enumerate(point.laws):
        counts, missed, n = counts_of(model, point, judged, s, judged.placed)
        m = len(model.reports.models[s].sigmas)
        laws[s] = law.refitted(counts, m, model.unknown[s], model.laws[s])
        if wrong[s] > 0.0:
            wrong[s] = (missed + WRONG_ROWS * model.wrong_shares[s]) / (n + WRONG_ROWS)
    return replace(point, laws=tuple(laws), wrong=wrong)


def some_targets(count: IntArray, most: int) -> IntArray | None:
    """Evenly chosen targets with about `most` reports in all; None if that is all of them."""
    total = int(count.sum())
    if total <= most:
        return None
    wanted = np.arange(0.0, len(count), total / most)
    return np.unique(wanted.astype(np.int64))


def constant_square(
    model: TrackModel, point: Point, smoothed: SmoothedTracks
) -> tuple[FloatArray, int]:
    """Expected sum of squares (c,) of the constants over the targets, and how many those are."""
    start = point.tangent.equations.target_start
    first = start[:-1][np.diff(start) > 0]
    own = slice(2 * model.reports.dim, None)
    square = (smoothed.mean[first, own] ** 2).sum(axis=0)
    if smoothed.covariance is not None:
        square = square + np.einsum("naa->a", smoothed.covariance[first][:, own, own])
    return square, len(first)


def refit_constants(model: TrackModel, point: Point, smoothed: SmoothedTracks) -> Point:
    """Spread of the constants of targets over the targets, with a weak prior."""
    if model.reports.num_constants == 0:
        return point
    square, K = constant_square(model, point, smoothed)
    prior = CONSTANT_TARGETS * np.asarray(model.constant_sd) ** 2
    spread = np.sqrt((square + prior) / (K + CONSTANT_TARGETS))
    return replace(point, constant_sd=np.where(model.constant_known, model.constant_sd, spread))
