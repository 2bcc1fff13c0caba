"""Which error term is missing: score tests of all candidates from one pass at the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks import BiasInformation, eliminate_paths
from probreg.posterior.tracks.fit import TrackFit
from probreg.posterior.tracks.steps import steady_path
from probreg.problems.recording.sensor_model import ErrorTerm
from probreg.problems.recording.track_reports import TrackReports
from probreg.typing import FloatArray

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
    model, p = fit.model, len(fit.theta)
    found = _with_candidates(fit, candidates)
    J, eta = found.precision, found.shift
    prior = np.linalg.inv(model.prior.covariance)
    own = J[:p, :p] + prior
    pull = eta[:p] + prior @ (model.prior.mean - fit.theta)
    taken = np.linalg.solve(own, J[:p, p:]) if p else np.zeros((0, len(candidates)))
    slope = eta[p:] - taken.T @ pull
    whole = np.diag(J)[p:]
    left = whole - np.einsum("pc,pc->c", J[:p, p:], taken)
    known = left > LEAST_SHARE * whole
    safe = np.where(known, left, 1.0)
    return Scores(
        np.where(known, slope**2 / safe, 0.0),
        np.where(known, slope / safe, 0.0),
        np.where(known, 1.0 / np.sqrt(safe), np.inf),
    )


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
    p = len(fit.theta)
    found = _with_candidates(fit, candidates)
    J, slope = found.precision_by_target, found.shift_by_target[:, p:]
    # estimated biases take a part of each target's slope
    taken = np.einsum("kcp,pq,kcq->kc", J[:, p:, :p], fit.covariance, J[:, p:, :p])
    own = np.maximum(np.einsum("kcc->kc", J[:, p:, p:]) - taken, 0.0)
    beyond = (slope**2 - own).sum(axis=0)
    whole = (own**2).sum(axis=0)
    safe = np.where(whole > 0.0, whole, 1.0)
    return SpreadScores(beyond / np.sqrt(2.0 * safe), np.sqrt(np.maximum(beyond / safe, 0.0)))


def _with_candidates(
    fit: TrackFit, candidates: Sequence[Mapping[int, ErrorTerm]]
) -> BiasInformation:
    """Of biases and candidates together, at the fit and zero."""
    model, old = fit.model, fit.point.tangent
    reports = _with(model.reports, candidates)
    theta = np.concatenate([fit.theta, np.zeros(len(candidates))])
    steady = steady_path(model, fit.point, fit.theta) if reports.varies else None
    tangent = reports.linearise(theta, old.path(fit.mean[old.rows]), steady)
    density = fit.point.density * model.caution
    motion = model.motion(tangent.equations, density, fit.point.constant_sd)
    weights = fit.point.weights[old.order][tangent.rows]
    return eliminate_paths(tangent.equations, motion, len(theta), weights)


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
    return replace(reports, models=tuple(models), num_biases=p + len(candidates))
