"""Metropolis-Hastings with proposals that do not depend on the state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.posterior.posterior import Posterior
from probreg.samplers._draws import Draws
from probreg.samplers._start import require_target, start_states
from probreg.samplers.moves import LaplaceT


@dataclass(frozen=True)
class Independence:
    """Proposals from a Student-t at the mode, accepted by Metropolis-Hastings.

    Parameters
    ----------
    df : float
        Degrees of freedom of the proposal.
    warmup : int
        Steps before the first draw.
    """

    df: float = 5.0
    warmup: int = 20

    def sample(
        self, posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> Draws:
        """All chains step together; `facts` has "acceptance"."""
        require_target(posterior, num_draws, num_chains, rng)
        proposal = LaplaceT(self.df).ready(posterior, 1.0)
        x, log_prob = start_states(posterior, num_chains, rng)
        ratio = log_prob - proposal.log_density(x)
        states, heights, accepted = [], [], 0.0
        for step in range(self.warmup + num_draws):
            new = proposal.sample(rng, num_chains)
            new_log_prob = posterior.log_prob(new)
            new_ratio = new_log_prob - proposal.log_density(new)
            taken = np.log(rng.random(num_chains)) < new_ratio - ratio
            x, ratio = np.where(taken[:, None], new, x), np.where(taken, new_ratio, ratio)
            log_prob = np.where(taken, new_log_prob, log_prob)
            if step >= self.warmup:
                states.append(x)
                heights.append(log_prob)
                accepted += float(taken.mean()) / num_draws
        return Draws(
            posterior,
            posterior.natural(np.stack(states, axis=1)),
            sampler=repr(self),
            stats={"log_prob": np.stack(heights, axis=1)},
            facts={"acceptance": accepted},
        )
