"""Importance sampling from a Student-t at the mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg import arviz_adapter
from probreg.errors import InvalidInputError
from probreg.numerics.resampling import systematic
from probreg.posterior.posterior import Posterior
from probreg.samplers._draws import Draws
from probreg.samplers._start import require_target
from probreg.samplers.moves import LaplaceT
from probreg.validation import positive_number


@dataclass(frozen=True)
class Importance:
    """Independent draws from `LaplaceT`, weighted, Pareto-smoothed and resampled.

    There is no chain to converge, so it suits many rows, where each density is dear. The
    Pareto k says whether the proposal covers the posterior: above 0.7 it does not.

    Parameters
    ----------
    df : float
        Degrees of freedom of the proposal.
    oversample : float
        Proposals for each draw kept.
    """

    df: float = 5.0
    oversample: float = 4.0

    def __post_init__(self) -> None:
        positive_number("df", self.df)
        if not self.oversample >= 1.0:
            raise InvalidInputError(f"oversample is {self.oversample}; 1 is the least.")

    def sample(
        self, posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> Draws:
        """Draw, weigh and resample; "chains" share one set of proposals.

        Draws are resampled in random order, so a proposal of large weight appears several
        times. `facts` has "pareto_k", "importance_ess" (effective proposals) and
        "log_evidence", the log of the normalising constant.
        """
        require_target(posterior, num_draws, num_chains, rng)
        density = LaplaceT(self.df).ready(posterior, 1.0)
        wanted = num_draws * num_chains
        proposals = max(int(np.ceil(self.oversample * wanted)), 100)
        x = density.sample(rng, proposals)
        log_prob = posterior.log_prob(x)
        ratios = log_prob - density.log_density(x)
        ratios = np.where(np.isnan(ratios), -np.inf, ratios)
        if not np.isfinite(ratios).any():
            raise InvalidInputError("no proposal has a finite density; check data and box.")
        weights, k = arviz_adapter.smooth_weights(ratios)
        share = np.exp(weights)
        chosen = rng.permutation(systematic(share, wanted, rng))
        shape = (num_chains, num_draws)
        facts = {
            "pareto_k": k,
            "importance_ess": float(1.0 / np.sum(share**2)),
            "log_evidence": float(np.logaddexp.reduce(ratios) - np.log(proposals)),
        }
        theta = posterior.natural(x[chosen]).reshape(*shape, posterior.dim)
        stats = {"log_prob": log_prob[chosen].reshape(shape)}
        return Draws(posterior, theta, sampler=repr(self), stats=stats, facts=facts)
