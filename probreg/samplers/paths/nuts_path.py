"""The no-U-turn sampler on whole paths, whitened by the Gaussian reference."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from probreg import extras
from probreg.arviz_adapter import MIN_DRAWS
from probreg.errors import InvalidInputError
from probreg.posterior.path_posterior import PathPosterior
from probreg.posterior.torch_bridge import as_torch
from probreg.samplers.nuts import Nuts, run_chain
from probreg.samplers.paths._draws import PathDraws, require_paths
from probreg.typing import FloatArray


@dataclass(frozen=True)
class NutsPath:
    """NUTS in the coordinates of the Gaussian reference: without them the geometry defeats it.

    Chains run one after the other, each with its own seed; the mass matrix stays the
    identity, which the coordinates make right.

    Parameters
    ----------
    settings : Nuts
        Warm-up, target acceptance, tree depth.
    """

    settings: Nuts = field(default_factory=lambda: Nuts(warmup=150))

    def sample(
        self, posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> PathDraws:
        """Draw chain by chain, each seeded from the generator; `stats` has "diverging".

        Raises
        ------
        InvalidInputError
            Also of fewer draws than convergence can be judged by.
        MissingExtraError
            Torch or Pyro are not installed.
        """
        extras.require("nuts", "NutsPath")
        require_paths(posterior, num_draws, num_chains, rng)
        if num_draws < MIN_DRAWS:
            raise InvalidInputError(f"NutsPath needs at least {MIN_DRAWS} draws a chain.")

        def potential(flat: FloatArray) -> tuple[float, FloatArray]:
            value, slope = posterior.log_prob_and_grad(flat.reshape(1, *posterior.shape))
            return -float(value[0]), -slope.ravel()

        size = int(np.prod(posterior.shape))
        kept = np.empty((num_chains, num_draws, size))
        diverging = np.zeros((num_chains, num_draws), dtype=bool)
        for c in range(num_chains):
            start, seed = rng.standard_normal(size), int(rng.integers(2**31))
            kept[c], bad, _ = run_chain(
                self.settings, as_torch(potential), start, num_draws, seed, full_mass=False
            )
            diverging[c, bad] = True
        z = kept.reshape(-1, *posterior.shape)
        paths = posterior.reference.paths(z).reshape(num_chains, num_draws, *posterior.shape)
        return PathDraws(posterior, paths, sampler=repr(self), stats={"diverging": diverging})
