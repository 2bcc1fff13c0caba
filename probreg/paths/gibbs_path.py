"""Gibbs sampling of paths under Gaussian scale mixtures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import ScaleMixture
from probreg.path_posterior import PathPosterior
from probreg.paths._draws import PathDraws, require_paths
from probreg.reweighting import per_component


@dataclass(frozen=True)
class GibbsPath:
    """Draw the rows' hidden precisions, then the whole path by the simulation smoother.

    Parameters
    ----------
    warmup : int
        Sweeps before the first draw.
    """

    warmup: int = 50

    def __post_init__(self) -> None:
        if self.warmup < 0:
            raise InvalidInputError("warmup must be zero or more.")

    def sample(
        self, posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> PathDraws:
        """Draw whole paths.

        Parameters
        ----------
        posterior : PathPosterior
        num_draws, num_chains : int
        rng : numpy.random.Generator

        Raises
        ------
        InvalidInputError
            The law is no Gaussian scale mixture.
        """
        require_paths(posterior, num_draws, num_chains, rng)
        noise = posterior.noise
        if not isinstance(noise, ScaleMixture) or not noise.scale_mixture:
            raise InvalidInputError(
                f"{noise!r} is not a Gaussian given a hidden precision. Take MetropolisPath or "
                "NutsPath."
            )
        model, size = posterior.trajectory, np.maximum(posterior.row_sizes, 1)
        kept = np.empty((num_chains, num_draws, *posterior.shape))
        start = posterior.reference.paths(rng.standard_normal((num_chains, *posterior.shape)))
        for c in range(num_chains):
            path = start[c]
            for k in range(-self.warmup, num_draws):
                v = posterior.residual(path)
                precision = per_component(noise.draw_precision(rng, v, size), v)
                path = model.draw(rng, 1, model.filter(precision.reshape(model.y.shape)))[0]
                if k >= 0:
                    kept[c, k] = path
        return PathDraws(posterior, kept, {}, repr(self), {"warmup": self.warmup})
