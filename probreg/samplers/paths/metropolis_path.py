"""Metropolis-Hastings on whole paths, proposed from the Gaussian reference."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from probreg.errors import InvalidInputError
from probreg.posterior.path_posterior import PathPosterior
from probreg.samplers.paths._draws import PathDraws, require_paths

TARGET = 0.3


@dataclass(frozen=True)
class MetropolisPath:
    """Blocks of scans proposed from their exact Gaussian conditional.

    In the reference's coordinates the Gaussian is standard normal, so the conditional of a
    block is too. A proposal steps towards a fresh draw of it (autoregressive, preconditioned
    Crank-Nicolson) and keeps the reference invariant: only the ratio of the rows' densities to
    their Gaussian stand-ins decides. All chains advance together.

    Parameters
    ----------
    warmup : int
        Sweeps over all scans before the first draw; the step's length is tuned in them only.
    thin : int
        Sweeps from draw to draw.
    block : int
        Scans in a block; the whole path where it has no more.
    """

    warmup: int = 100
    thin: int = 1
    block: int = 10

    def __post_init__(self) -> None:
        if self.warmup < 0 or self.thin < 1 or self.block < 1:
            raise InvalidInputError(
                "warmup must be zero or more, thin and block one or more: "
                f"{self.warmup}, {self.thin}, {self.block}."
            )

    def sample(
        self, posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> PathDraws:
        """Draw; `facts` has the acceptance rate after warm-up and the tuned step."""
        require_paths(posterior, num_draws, num_chains, rng)
        z = rng.standard_normal((num_chains, *posterior.shape))
        ratio = posterior.log_ratio(posterior.reference.paths(z))
        kept = np.empty((num_draws, num_chains, *posterior.shape))
        step, rates = 0.5, []
        for k in range(-self.warmup, num_draws * self.thin):
            share = 0.0
            for block in self._blocks(posterior.shape[0], rng):
                new = z.copy()
                fresh = rng.standard_normal(z[:, block].shape)
                new[:, block] = np.sqrt(1.0 - step**2) * z[:, block] + step * fresh
                height = posterior.log_ratio(posterior.reference.paths(new))
                accepted = np.log(rng.random(num_chains)) < height - ratio
                z = np.where(accepted[:, None, None], new, z)
                ratio = np.where(accepted, height, ratio)
                share += accepted.mean() * (block.stop - block.start) / posterior.shape[0]
            if k < 0:
                gain = (k + self.warmup + 1.0) ** -0.6
                odds = step / (1.0 - step) * np.exp(gain * (share - TARGET))
                step = float(min(odds / (1.0 + odds), 1.0 - 1e-9))
                continue
            rates.append(share)
            if (k + 1) % self.thin == 0:
                kept[k // self.thin] = z
        flat = kept.reshape(-1, *posterior.shape)
        paths = posterior.reference.paths(flat).reshape(kept.shape)
        facts = {"acceptance": float(np.mean(rates)), "step": step}
        return PathDraws(posterior, np.swapaxes(paths, 0, 1), sampler=repr(self), facts=facts)

    def _blocks(self, scans: int, rng: np.random.Generator) -> list[slice]:
        """Blocks that cover all scans once, their edges at random."""
        first = int(rng.integers(self.block)) if scans > self.block else 0
        edges = np.unique(np.clip([0, *range(first, scans, self.block), scans], 0, scans))
        return [slice(int(a), int(b)) for a, b in pairwise(edges)]
