"""Which error term is missing: score tests of all candidates from one pass at the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks import TrackEquations, TrackMotion, eliminate_paths
from probreg.posterior.tracks.drifting import Evidence, coefficients
from probreg.posterior.tracks.fit import TrackFit
from probreg.posterior.tracks.steps import Information, information_of, steady_path
from probreg.problems.recording.knots import Knots
from probreg.problems.recording.linearisation import TrackLinearisation
from probreg.problems.recording.sensor_model import ErrorTerm
from probreg.problems.recording.track_reports import TrackReports
from probreg.typing import FloatArray, IntArray

LEAST_SHARE = 1e-9  # of a candidate's information that the estimated biases do not take


class Scores(NamedTuple):
    """What reports say of terms that the model leaves out, each alone.

    Attributes
    ----------
    chi2 : ndarray, shape (c,)
        One degree of freedom; zero where the biases of the model take all of a term's effect.
    value, sd : ndarray, shape (c,)
        One step's estimate of the coefficient if it were in the model, without a prior.
    """

    chi2: FloatArray
    value: FloatArray
    sd: FloatArray


def score_missing(fit: TrackFit, candidates: Sequence[Mapping[int, ErrorTerm]]) -> Scores:
    """Score tests of terms that are not in the model.

    Parameters
    ----------
    fit : TrackFit
    candidates : sequence of mapping of int to ErrorTerm
        For each candidate the sensors, by number, that have it with one coefficient in common.

    Returns
    -------
    Scores

    Raises
    ------
    InvalidInputError
        No candidate, one of no sensor, or one of a sensor that is not there.

    References
    ----------
    Rao, "Large sample tests of statistical hypotheses" (1948).
    """
    found, old, new = _with_candidates(fit, candidates)
    J, eta = found.precision, found.shift
    own, both = J[np.ix_(old, old)], J[np.ix_(old, new)]
    taken, lost = _taken(fit, own, eta[old], both)
    slope = eta[new] - lost
    whole = np.diag(J)[new]
    left = whole - np.einsum("pc,pc->c", both, taken)
    known = left > LEAST_SHARE * whole
    safe = np.where(known, left, 1.0)
    return Scores(
        np.where(known, slope**2 / safe, 0.0),
        np.where(known, slope / safe, 0.0),
        np.where(known, 1.0 / np.sqrt(safe), np.inf),
    )


def _taken(
    fit: TrackFit, J: FloatArray, eta: FloatArray, both: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What coefficients of the model take: of candidates (P, c), and of their slopes (c,)."""
    model = fit.model
    if model.drift is not None:
        assert fit.point.spreads is not None
        evidence = Evidence.at(model.drift, J, eta, fit.theta, 0.0)
        found = coefficients(model.drift, evidence, fit.point.spreads)
        return found.covariance @ both, both.T @ (found.mean - fit.theta)
    prior = np.linalg.inv(model.prior.covariance)
    own = J + prior
    pull = eta + prior @ (model.prior.mean - fit.theta)
    taken = np.linalg.solve(own, both) if len(eta) else np.zeros(both.shape)
    return taken, taken.T @ pull


class SpreadScores(NamedTuple):
    """What reports say of errors that belong to targets, each alone.

    Attributes
    ----------
    z : ndarray, shape (c,)
        Near standard normal where targets have none, large where they have. Far below zero, as
        for clocks of all sensors together, where paths take the constant's effect.
    sd : ndarray, shape (c,)
        One step's estimate of their standard deviation over the targets.
    """

    z: FloatArray
    sd: FloatArray


def score_spread(fit: TrackFit, candidates: Sequence[Mapping[int, ErrorTerm]]) -> SpreadScores:
    """Score tests of constants of targets, whose variance is zero if targets have none.

    Parameters
    ----------
    fit : TrackFit
    candidates : sequence of mapping of int to ErrorTerm
        For each candidate the sensors, by number, that have it, with one coefficient a target.

    Returns
    -------
    SpreadScores

    Raises
    ------
    InvalidInputError
        As `score_missing`.

    References
    ----------
    Verbeke and Molenberghs, "The use of score tests for inference on variance components",
    Biometrics 59 (2003).
    """
    J, slope, taken = _by_target(fit, candidates)
    own = np.maximum(np.einsum("kcc->kc", J) - taken, 0.0)
    beyond = (slope**2 - own).sum(axis=0)
    whole = (own**2).sum(axis=0)
    safe = np.where(whole > 0.0, whole, 1.0)
    return SpreadScores(beyond / np.sqrt(2.0 * safe), np.sqrt(np.maximum(beyond / safe, 0.0)))


def _by_target(
    fit: TrackFit, candidates: Sequence[Mapping[int, ErrorTerm]]
) -> tuple[FloatArray, FloatArray, FloatArray | float]:
    """Precision (K, c, c) and slope (K, c) of candidates, and what estimated biases take (K, c)."""
    p = len(fit.theta)
    reports, tangent, motion, weights = _extended(fit, candidates)
    if fit.knots.drifting:
        # a target has a small part in what is known of coefficients that many others tell
        only = _only(tangent.equations, reports.coefficients, len(candidates))
        found = eliminate_paths(only, motion, len(candidates), weights)
        return found.precision_by_target, found.shift_by_target, 0.0
    found = eliminate_paths(tangent.equations, motion, p + len(candidates), weights)
    J = found.precision_by_target
    # estimated biases take a part of each target's slope
    taken = np.einsum("kcp,pq,kcq->kc", J[:, p:, :p], fit.covariance, J[:, p:, :p])
    return J[:, p:, p:], found.shift_by_target[:, p:], taken


def _only(equations: TrackEquations, knots: Knots, count: int) -> TrackEquations:
    """Equations of the last constant biases alone."""
    own = equations.column - (knots.num_static - count)
    there = (own >= 0) & (own < count)
    return equations._replace(
        column=np.where(there, own, 0), response=np.where(there, equations.response, 0.0)
    )


class _Extended(NamedTuple):
    """Reports, tangent, motion and weights with candidates, at the fit and zero."""

    reports: TrackReports
    tangent: TrackLinearisation
    motion: TrackMotion
    weights: FloatArray


def _with_candidates(
    fit: TrackFit, candidates: Sequence[Mapping[int, ErrorTerm]]
) -> tuple[Information, IntArray, IntArray]:
    """Of coefficients and candidates together, and where both stand."""
    reports, tangent, motion, weights = _extended(fit, candidates)
    _, old = fit.knots.with_more(len(candidates))
    knots = reports.coefficients
    new = np.setdiff1d(np.arange(knots.size), old)
    return information_of(knots, tangent.equations, motion, weights), old, new


def _extended(fit: TrackFit, candidates: Sequence[Mapping[int, ErrorTerm]]) -> _Extended:
    model, point = fit.model, fit.point
    reports = _with(model.reports, candidates)
    theta = np.zeros(reports.coefficients.size)
    theta[fit.knots.with_more(len(candidates))[1]] = fit.theta
    steady = steady_path(model, point, fit.theta) if reports.varies else None
    old = point.tangent
    tangent = reports.linearise(theta, old.path(fit.mean[old.rows]), steady)
    motion = model.motion(tangent.equations, point.density * model.caution, point.constant_sd)
    return _Extended(reports, tangent, motion, point.weights[old.order][tangent.rows])


def _with(reports: TrackReports, candidates: Sequence[Mapping[int, ErrorTerm]]) -> TrackReports:
    """Reports of sensors that have the candidates too."""
    models, p = list(reports.models), reports.num_biases
    if not candidates or not all(candidates):
        raise InvalidInputError("give at least one candidate, each with a sensor.")
    for c, candidate in enumerate(candidates):
        for s, term in candidate.items():
            if not 0 <= s < len(models):
                raise InvalidInputError(f"candidate {c} is of sensor {s}; there are {len(models)}.")
            models[s] = replace(models[s], terms=(*models[s].terms, (p + c, term)))
    knots, _ = reports.coefficients.with_more(len(candidates))
    return replace(reports, models=tuple(models), num_biases=p + len(candidates), knots=knots)
