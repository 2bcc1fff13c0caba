"""The posterior under the law chosen: its mode, whether chains agree with it, and its draws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.posterior.tracks import TrackFit, TrackModel, fit_tracks
from probreg.posterior.tracks.steps import MANY_REPORTS
from probreg.registration._choice import Chosen
from probreg.registration._identities import Identified
from probreg.registration._track_model import under
from probreg.samplers.tracks import BiasDraws, GibbsTracks, ModeCheck, check_mode, normal_draws
from probreg.typing import FloatArray

CHAINS, SWEEPS = 4, 200
MODE, GIBBS, SCALED = "normal law at the mode", "Gibbs of tracks", "normal law, widened by chains"


class Fitted(NamedTuple):
    """The mode under the law chosen, and what chains say of it.

    Attributes
    ----------
    fit : TrackFit
        Of all tracks.
    check : ModeCheck
    draws : BiasDraws
    """

    fit: TrackFit
    check: ModeCheck
    draws: BiasDraws


def fit(known: Identified, chosen: Chosen) -> TrackFit:
    """Find the mode of all reports under the law chosen."""
    model: TrackModel = under(known.model, chosen.choice)
    return fit_tracks(model, near=chosen.fits.get(chosen.choice.name))


def draw(known: Identified, found: TrackFit, num_draws: int, rng: np.random.Generator) -> Fitted:
    """Draws of the normal law at the mode where short chains agree with it, else of chains.

    Of more reports than chains can take, the normal law is widened as the chains of some say.
    """
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
