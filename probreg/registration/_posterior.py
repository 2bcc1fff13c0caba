"""The posterior under the law chosen: its mode, whether chains agree with it, and its draws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.posterior.tracks import (
    TrackFit,
    TrackModel,
    draw_drift,
    evidence_at,
    fit_tracks,
    with_draws,
)
from probreg.posterior.tracks.steps import MANY_REPORTS
from probreg.registration._choice import Chosen
from probreg.registration._identities import Identified
from probreg.registration._track_model import under
from probreg.samplers.tracks import (
    BiasDraws,
    BiasPathDraws,
    GibbsTracks,
    ModeCheck,
    check_mode,
    normal_draws,
)
from probreg.typing import FloatArray

CHAINS, SWEEPS = 4, 200
MODE, GIBBS, SCALED = "normal law at the mode", "Gibbs of tracks", "normal law, widened by chains"
SPREADS = "Gibbs of spreads, then the normal law given them"


class Fitted(NamedTuple):
    """The mode under the law chosen, and what chains say of it.

    Attributes
    ----------
    fit : TrackFit
        Of all tracks.
    check : ModeCheck or None
        None where biases drift: their spreads are drawn, and the normal law is not judged.
    draws : BiasDraws
    """

    fit: TrackFit
    check: ModeCheck | None
    draws: BiasDraws


def fit(known: Identified, chosen: Chosen) -> TrackFit:
    """Find the mode of all reports under the law chosen."""
    model: TrackModel = under(known.model, chosen.choice)
    return fit_tracks(model, near=chosen.fits.get(chosen.choice.name))


def draw(known: Identified, found: TrackFit, num_draws: int, rng: np.random.Generator) -> Fitted:
    """Draws of the normal law at the mode where short chains agree with it, else of chains.

    Of more reports than chains can take, the normal law is widened as the chains of some say.
    """
    if found.model.drift is not None:
        return _draw_drifting(known, found, num_draws, rng)
    check = check_mode(found, rng)
    names = known.problem.names, known.problem.units
    facts = {
        "sd_ratio": float(check.sd_ratio[np.argmax(np.abs(check.sd_ratio - 1.0))]),
        "shift": float(np.abs(check.shift).max()),
    }
    each = -(-num_draws // CHAINS)
    if check.agrees:
        theta = normal_draws(found.theta, found.covariance, (CHAINS, each), rng)
        return Fitted(found, check, _draws(theta, MODE, names, {**facts, "independent": 1.0}))
    if len(found.model.reports) <= MANY_REPORTS:
        theta = _chains(found, each, rng)
        return Fitted(found, check, _draws(theta, GIBBS, names, facts))
    wider = 1.0 / check.sd_ratio
    covariance = found.covariance * np.outer(wider, wider)
    theta = normal_draws(found.theta, covariance, (CHAINS, each), rng)
    return Fitted(found, check, _draws(theta, SCALED, names, {**facts, "independent": 1.0}))


def _draw_drifting(
    known: Identified, found: TrackFit, num_draws: int, rng: np.random.Generator
) -> Fitted:
    """Paths of the biases with their spreads drawn; the fit moves to the mean of the draws."""
    prior, spreads = found.model.drift, found.point.spreads
    assert prior is not None
    assert spreads is not None
    evidence, each = evidence_at(found), -(-num_draws // CHAINS)
    chains = [draw_drift(prior, evidence, spreads, each, rng) for _ in range(CHAINS)]
    theta = np.array([chain.theta for chain in chains])
    knots = found.knots
    paths = BiasPathDraws(
        knots.drifting,
        prior.kinds,
        knots.time,
        np.stack([theta[..., knots.places(bias)] for bias in knots.drifting], axis=-1),
        np.array([chain.spread for chain in chains]),
        np.mean([chain.constant for chain in chains], axis=0),
    )
    draws = BiasDraws(
        theta=knots.averages(theta),
        labels=known.problem.names,
        symbols=known.problem.units,
        sampler=SPREADS,
        paths=paths,
    )
    return Fitted(with_draws(found, theta.reshape(-1, knots.size)), None, draws)


def _draws(
    theta: FloatArray,
    sampler: str,
    names: tuple[tuple[str, ...], tuple[str, ...]],
    facts: dict[str, float],
) -> BiasDraws:
    return BiasDraws(theta=theta, labels=names[0], symbols=names[1], sampler=sampler, facts=facts)


def _chains(found: TrackFit, each: int, rng: np.random.Generator) -> FloatArray:
    """Draws (chains, each, p): of every sweep several, given its weights."""
    drawn = GibbsTracks().sample(found, SWEEPS, CHAINS, rng)
    sweep = np.linspace(0, SWEEPS - 1e-9, each).astype(int)
    mean = drawn.conditional_mean[:, sweep]
    root = np.linalg.cholesky(drawn.conditional_covariance[:, sweep])
    noise = rng.standard_normal(mean.shape)
    return np.asarray(mean + np.einsum("cdij,cdj->cdi", root, noise))
