"""Which constant biases drift: each alone, from one pass at a fit without drift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.posterior.tracks.drifting import DriftPrior, Evidence, profile
from probreg.posterior.tracks.fit import TrackFit
from probreg.posterior.tracks.steps import information_of, steady_path
from probreg.problems.recording.knots import Knots
from probreg.sensors.drifts import Drift
from probreg.typing import FloatArray

SPACING_S = 60.0
MOST_COEFFICIENTS = 600


class DriftScores(NamedTuple):
    """What reports say of a drift of each bias, others as they are in the fit.

    Attributes
    ----------
    gain : ndarray, shape (p,)
        Log marginal likelihood at the best spread, over that of a constant; zero of biases that
        drift in the fit.
    constant : ndarray, shape (p,)
        Probability that the bias does not drift.
    spread : ndarray, shape (p,)
        The best one, SI units.
    """

    gain: FloatArray
    constant: FloatArray
    spread: FloatArray


def score_drift(fit: TrackFit, kind: Drift, scale: Sequence[float] | FloatArray) -> DriftScores:
    """Exact marginal likelihoods of drifts at the weights of a fit without them.

    Parameters
    ----------
    fit : TrackFit
    kind : Drift
        Of those that are tested.
    scale : ndarray, shape (p,)
        Prior median of the spread of each bias.
    """
    model, p = fit.model, fit.knots.num_biases
    knots = _knots(p, model.reports.time)
    kinds, spread = [kind] * p, np.zeros(p)
    if fit.point.spreads is not None:
        for j, bias in enumerate(fit.knots.drifting):
            kinds[bias], spread[bias] = model.drifts[j][0], fit.point.spreads.spread[j]
    prior = DriftPrior(model.prior, knots, tuple(kinds), np.asarray(scale, dtype=float))
    evidence = _evidence(fit, prior)
    at = prior.usual._replace(spread=spread)
    profiles = [profile(prior, evidence, at, j) for j in range(p)]
    new = ~np.isin(np.arange(p), fit.knots.drifting)
    return DriftScores(
        np.where(new, [one.log_density.max() for one in profiles], 0.0),
        np.array([one.constant for one in profiles]),
        np.array([one.best for one in profiles]),
    )


def _evidence(fit: TrackFit, prior: DriftPrior) -> Evidence:
    """What reports say of coefficients at other knots than those of the fit."""
    model, point, knots = fit.model, fit.point, prior.knots
    reports = replace(model.reports, knots=knots)
    values = fit.knots.at(fit.theta, knots.time)
    theta = np.empty(knots.size)
    for bias in range(knots.num_biases):
        theta[knots.places(bias)] = values[:, bias]
    steady = steady_path(model, point, fit.theta) if reports.varies else None
    old = point.tangent
    tangent = reports.linearise(theta, old.path(fit.mean[old.rows]), steady)
    motion = model.motion(tangent.equations, point.density * model.caution, point.constant_sd)
    weights = point.weights[old.order][tangent.rows]
    found = information_of(knots, tangent.equations, motion, weights)
    return Evidence.at(prior, found.precision, found.shift, theta, found.log_likelihood)


def _knots(p: int, time: FloatArray) -> Knots:
    """A knot a minute, or fewer, of all biases."""
    first, last = float(time.min()), float(time.max())
    count = min(int(np.ceil((last - first) / SPACING_S)), MOST_COEFFICIENTS // p)
    edges = np.linspace(first, max(last, first + 1.0), max(count, 1) + 1)
    return Knots(p, tuple(range(p)), edges)
