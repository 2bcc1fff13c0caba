"""Draws of drifting biases with their spreads, given what all reports say of the coefficients."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.posterior.tracks.drifting import (
    DriftPrior,
    Evidence,
    Spreads,
    coefficients,
    others_out,
    profile,
)
from probreg.typing import FloatArray

SWEEPS, WARMUP = 100, 20
MANY, FEW_SWEEPS = 400, 40  # coefficients from which a sweep is dear, and what must do
RARE = 1e-3  # precision of a part below which it is a step
REACH = 3  # parts by which a step is moved at most


@dataclass(frozen=True, eq=False)
class DriftDraws:
    """Draws of all coefficients, and the spreads that they were drawn under.

    Attributes
    ----------
    theta : ndarray, shape (draws, P)
    spread : ndarray, shape (draws, d)
        Zero in draws without drift.
    constant : ndarray, shape (d,)
        Probability that each of the biases does not drift.
    """

    theta: FloatArray
    spread: FloatArray
    constant: FloatArray


def draw_drift(
    prior: DriftPrior,
    evidence: Evidence,
    near: Spreads,
    num_draws: int,
    rng: np.random.Generator,
) -> DriftDraws:
    """Gibbs sampling of spreads and steps, with several draws of the coefficients each time.

    Every spread is drawn from its exact conditional on a grid, coefficients integrated out.
    """
    heavy = any(np.isfinite(kind.freedom) for kind in prior.kinds)
    sweeps = FEW_SWEEPS if len(prior.mean) > MANY else SWEEPS
    sweeps = 3 * sweeps if heavy else sweeps
    counts = np.diff(np.linspace(0, num_draws, sweeps + 1).astype(int))
    theta, spread, constant, spreads = [], [], [], near
    for k in range(-WARMUP, sweeps):
        spreads, zero = draw_spreads(prior, evidence, spreads, rng)
        found = coefficients(prior, evidence, spreads)
        drawn = found.draw(rng, max(1, counts[max(k, 0)]))
        spreads = draw_precisions(prior, spreads, drawn[0], rng)
        if k >= 0:
            theta.append(drawn[: counts[k]])
            spread.append(np.tile(spreads.spread, (counts[k], 1)))
            constant.append(zero)
    return DriftDraws(np.concatenate(theta), np.concatenate(spread), np.mean(constant, axis=0))


def draw_spreads(
    prior: DriftPrior, evidence: Evidence, spreads: Spreads, rng: np.random.Generator
) -> tuple[Spreads, FloatArray]:
    """Each spread given the others, and the probability (d,) that it is zero."""
    zero = np.empty(len(prior.kinds))
    for j, kind in enumerate(prior.kinds):
        if np.isfinite(kind.freedom) and spreads.spread[j] > 0.0:
            spreads = _moved_steps(prior, evidence, spreads, j, rng)
        found = profile(prior, evidence, spreads, j)
        zero[j] = found.constant
        total = np.cumsum(np.exp(found.log_posterior))
        spread = spreads.spread.copy()
        spread[j] = found.spread[np.searchsorted(total, rng.random() * total[-1])]
        spreads = spreads._replace(spread=spread)
    return spreads, zero


def draw_precisions(
    prior: DriftPrior, spreads: Spreads, theta: FloatArray, rng: np.random.Generator
) -> Spreads:
    """Precisions of parts with heavy tails given the coefficients (P,)."""
    precision = list(spreads.precision)
    for j, kind in enumerate(prior.kinds):
        if not np.isfinite(kind.freedom):
            continue
        m = len(precision[j])
        square = np.zeros(m)
        if spreads.spread[j] > 0.0:
            own = theta[prior.knots.places(prior.knots.drifting[j])]
            size = np.sqrt(kind.step_variance(np.diff(prior.knots.time)))
            square = (np.diff(own) / (spreads.spread[j] * size)) ** 2
            precision[j] = rng.gamma(0.5 * (kind.freedom + 1.0), 2.0 / (kind.freedom + square))
        else:
            precision[j] = rng.gamma(0.5 * kind.freedom, 2.0 / kind.freedom, m)
    return spreads._replace(precision=tuple(precision))


def _moved_steps(
    prior: DriftPrior, evidence: Evidence, spreads: Spreads, j: int, rng: np.random.Generator
) -> Spreads:
    """Offer each step another interval near by: exchange the precisions of two parts."""
    even = spreads._replace(precision=(*spreads.precision[:j], np.ones_like(spreads.precision[j]),
                                       *spreads.precision[j + 1 :]))  # fmt: skip
    A, c = others_out(prior, evidence, even, j)
    precision, m = spreads.precision[j].copy(), len(spreads.precision[j])
    here = _log_density(A, c, spreads.spread[j] / np.sqrt(precision))
    for _ in range(int((precision < RARE).sum())):
        # any step may go any way, so that each exchange is as likely as the one back
        i = rng.choice(np.flatnonzero(precision < RARE))
        other = i + rng.integers(1, REACH + 1) * rng.choice([-1, 1])
        if not 0 <= other < m:
            continue
        moved = precision.copy()
        moved[[i, other]] = moved[[other, i]]
        there = _log_density(A, c, spreads.spread[j] / np.sqrt(moved))
        if np.log(rng.random()) < there - here:
            precision, here = moved, there
    parts = (*spreads.precision[:j], precision, *spreads.precision[j + 1 :])
    return spreads._replace(precision=parts)


def _log_density(A: FloatArray, c: FloatArray, size: FloatArray) -> float:
    """Of the reports, parts of standard deviations `size` (m,) integrated out."""
    L = np.linalg.cholesky(np.eye(len(c)) + size[:, None] * A * size)
    u = np.linalg.solve(L, size * c)
    return float(0.5 * u @ u - np.log(np.diag(L)).sum())
