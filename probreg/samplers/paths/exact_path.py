"""Independent paths where the noise is Gaussian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import Gaussian
from probreg.posterior.path_posterior import PathPosterior
from probreg.samplers.paths._draws import PathDraws, require_paths


@dataclass(frozen=True)
class ExactPath:
    """The simulation smoother: independent draws, no warm-up."""

    def sample(
        self, posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> PathDraws:
        """Draw independently.

        Raises
        ------
        InvalidInputError
            Also where the noise is not Gaussian.
        """
        require_paths(posterior, num_draws, num_chains, rng)
        if not isinstance(posterior.noise, Gaussian):
            raise InvalidInputError(
                f"there is no closed form under {type(posterior.noise).__name__} noise. Take "
                "GibbsPath, MetropolisPath or NutsPath."
            )
        z = rng.standard_normal((num_chains * num_draws, *posterior.shape))
        paths = posterior.reference.paths(z)
        path = paths.reshape(num_chains, num_draws, *posterior.shape)
        return PathDraws(posterior, path, sampler=repr(self))
