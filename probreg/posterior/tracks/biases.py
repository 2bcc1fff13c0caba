"""Biases of a fit, constant or drifting alike: by some targets, over time, with their spreads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from probreg.motion.tracks import BiasInformation, TrackEquations, TrackMotion, spans
from probreg.posterior.tracks import steps
from probreg.posterior.tracks.drifting import Evidence, coefficients
from probreg.posterior.tracks.fit import TrackFit
from probreg.typing import FloatArray, IntArray


def telling_targets(fit: TrackFit) -> IntArray:
    """Targets that say something of the biases."""
    found = fit.information
    if isinstance(found, BiasInformation):
        return np.flatnonzero(np.einsum("kpp->k", found.precision_by_target) > 0.0)
    return np.flatnonzero(found.telling)


def some_targets_say(fit: TrackFit, targets: IntArray) -> FloatArray:
    """Coefficients (P,) by some of the targets, at the weights and spreads of the fit."""
    found, model, tangent = fit.information, fit.model, fit.point.tangent
    if isinstance(found, BiasInformation):
        J = found.precision_by_target[targets].sum(axis=0)
        eta = found.shift_by_target[targets].sum(axis=0)
        pull = eta + model.prior.precision @ (model.prior.mean - tangent.theta)
        return np.asarray(tangent.theta + np.linalg.solve(J + model.prior.precision, pull))
    equations = tangent.equations
    motion = _motion(fit)
    said = steps.information_of(
        fit.knots,
        equations.of_targets(targets),
        TrackMotion(*(array[targets] for array in motion)),
        fit.point.weights[spans(equations.target_start, targets)],
    )
    assert model.drift is not None
    assert fit.point.spreads is not None
    evidence = steps.evidence_of(model, said, tangent.theta)
    return coefficients(model.drift, evidence, fit.point.spreads).mean


def bias_scores(fit: TrackFit) -> FloatArray:
    """Slope of each target's log likelihood along the coefficients at the fit, (K, P)."""
    found, delta = fit.information, fit.theta - fit.point.tangent.theta
    if isinstance(found, BiasInformation):
        return found.shift_by_target - found.precision_by_target @ delta
    equations = fit.point.tangent.equations
    clean = equations._replace(y=equations.minus_biases(delta))
    said = steps.information_of(fit.knots, clean, _motion(fit), fit.point.weights)
    return said.shift_by_target


def _motion(fit: TrackFit) -> TrackMotion:
    """As biases are solved for."""
    point, model = fit.point, fit.model
    return model.motion(point.tangent.equations, point.density * model.caution, point.constant_sd)


def evidence_at(fit: TrackFit) -> Evidence:
    """What all reports say of coefficients that drift, at the weights of the fit."""
    return steps.evidence_of(fit.model, fit.information, fit.point.tangent.theta)


def with_draws(fit: TrackFit, draws: FloatArray) -> TrackFit:
    """The fit with mean and covariance of draws (k, P), spreads mixed over, paths at that mean."""
    theta = draws.mean(axis=0)
    smoothed = steps.smooth(fit.model, fit.point, theta)
    judged = steps.judge(fit.model, fit.point, smoothed)
    order = fit.point.tangent.order
    return replace(
        fit,
        theta=theta,
        covariance=np.cov(draws.T),
        wrong=judged.wrong[order],
        log_density=judged.log_density[order],
        probability=judged.probability[order],
        mean=smoothed.mean[order],
    )


def local_covariance(fit: TrackFit, stamp: FloatArray) -> FloatArray:
    """Covariance (n, p, p) of the biases at stamps (n,)."""
    knots, C = fit.knots, fit.covariance
    left, share = knots.between(stamp)
    out = np.zeros((len(stamp), knots.num_biases, knots.num_biases))
    drifts = np.isin(np.arange(knots.num_biases), knots.drifting)
    first = np.stack([knots.places(b)[left if d else 0 * left]
                      for b, d in enumerate(drifts)], axis=1)  # fmt: skip
    second = np.where(drifts, first + len(knots.drifting), first)
    part = np.where(drifts, share[:, None], 0.0)
    for rows, one in ((first, 1.0 - part), (second, part)):
        for columns, other in ((first, 1.0 - part), (second, part)):
            own = C[rows[:, :, None], columns[:, None, :]]
            out += one[:, :, None] * other[:, None, :] * own
    return out


def as_constant(fit: TrackFit) -> TrackEquations:
    """Equations of the fit with one column a bias, which holds for as long as a track remembers."""
    knots, equations = fit.knots, fit.point.tangent.equations
    if not knots.drifting:
        return equations
    bias = np.empty(knots.size, dtype=np.int64)
    for b in range(knots.num_biases):
        bias[knots.places(b)] = b
    return equations._replace(column=bias[equations.column])
