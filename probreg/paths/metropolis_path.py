"""Metropolis-Hastings on whole paths, proposed from the Gaussian reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.path_posterior import PathPosterior
from probreg.paths._draws import PathDraws, require_paths

TARGET = 0.3


@dataclass(frozen=True)
class MetropolisPath:
    """Preconditioned Crank-Nicolson moves: an autoregressive step in the reference's coordinates.

    The proposal keeps the Gaussian reference invariant, so that only the ratio of the rows'
    densities to their Gaussian stand-ins decides, whatever the number of scans. All chains
    advance together.

    Parameters
    ----------
    warmup : int
        Steps before the first draw; the step's length is tuned in them only.
    thin : int
        Steps from draw to draw.
    """

    warmup: int = 300
    thin: int = 5

    def __post_init__(self) -> None:
        if self.warmup < 0 or self.thin < 1:
            raise InvalidInputError("warmup must be zero or more and thin one or more.")

    def sample(
        self, posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> PathDraws:
        """Draw whole paths.

        Parameters
        ----------
        posterior : PathPosterior
        num_draws, num_chains : int
        rng : numpy.random.Generator

        Returns
        -------
        PathDraws
            `facts` has the acceptance rate after warm-up and the tuned step.
        """
        require_paths(posterior, num_draws, num_chains, rng)
        z = rng.standard_normal((num_chains, *posterior.shape))
        ratio = posterior.log_ratio(posterior.reference.paths(z))
        kept = np.empty((num_draws, num_chains, *posterior.shape))
        step, rates = 0.5, []
        for k in range(-self.warmup, num_draws * self.thin):
            new = np.sqrt(1.0 - step**2) * z + step * rng.standard_normal(z.shape)
            height = posterior.log_ratio(posterior.reference.paths(new))
            accepted = np.log(rng.random(num_chains)) < height - ratio
            z = np.where(accepted[:, None, None], new, z)
            ratio = np.where(accepted, height, ratio)
            if k < 0:
                gain = (k + self.warmup + 1.0) ** -0.6
                odds = step / (1.0 - step) * np.exp(gain * (accepted.mean() - TARGET))
                step = float(odds / (1.0 + odds))
                continue
            rates.append(float(accepted.mean()))
            if (k + 1) % self.thin == 0:
                kept[k // self.thin] = z
        flat = kept.reshape(-1, *posterior.shape)
        paths = posterior.reference.paths(flat).reshape(kept.shape)
        facts = {"acceptance": float(np.mean(rates)), "step": step}
        return PathDraws(posterior, np.swapaxes(paths, 0, 1), {}, repr(self), facts)
