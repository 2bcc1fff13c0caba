"""Gibbs sampling of paths under Gaussian scale mixtures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import ScaleMixture, per_component
from probreg.posterior.path_posterior import PathPosterior
from probreg.samplers.paths._draws import PathDraws, require_paths
from probreg.samplers.paths._step_scale import StepScale, redraw
from probreg.typing import FloatArray


@dataclass(frozen=True)
class GibbsPath:
    """Draw the rows' hidden precisions, then the whole path by the simulation smoother.

    Parameters
    ----------
    warmup : int
        Sweeps before the first draw.
    unknown : tuple of StepScale
        Factors on the process noise that are sampled too, the path integrated out.
    """

    warmup: int = 50
    unknown: tuple[StepScale, ...] = ()

    def __post_init__(self) -> None:
        if self.warmup < 0:
            raise InvalidInputError("warmup must be zero or more.")

    def sample(
        self, posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> PathDraws:
        """Draw in turn.

        Raises
        ------
        InvalidInputError
            Also where the law is no Gaussian scale mixture.
        """
        require_paths(posterior, num_draws, num_chains, rng)
        noise = posterior.noise
        if not isinstance(noise, ScaleMixture) or not noise.scale_mixture:
            raise InvalidInputError(
                f"{noise!r} is not a Gaussian given a hidden precision. Take MetropolisPath or "
                "NutsPath."
            )
        kept = np.empty((num_chains, num_draws, *posterior.shape))
        factors = np.empty((num_chains, num_draws, len(self.unknown)))
        start = posterior.reference.paths(rng.standard_normal((num_chains, *posterior.shape)))
        for c in range(num_chains):
            path, log_factors = start[c], np.log([scale.median for scale in self.unknown])
            for k in range(-self.warmup, num_draws):
                path = self._sweep(posterior, path, log_factors, rng)
                if k >= 0:
                    kept[c, k], factors[c, k] = path, np.exp(log_factors)
        facts = {"warmup": self.warmup}
        return PathDraws(posterior, kept, factors, sampler=repr(self), facts=facts)

    def _sweep(
        self,
        posterior: PathPosterior,
        path: FloatArray,
        log_factors: FloatArray,
        rng: np.random.Generator,
    ) -> FloatArray:
        """Precisions given the path, factors given the precisions, and a path given both."""
        noise, model = posterior.noise, posterior.trajectory
        assert isinstance(noise, ScaleMixture)
        v = posterior.residual(path)
        drawn = noise.draw_precision(rng, v, np.maximum(posterior.row_sizes, 1))
        weights = per_component(drawn, v).reshape(model.y.shape)
        if self.unknown:
            filtered = redraw(model, weights, self.unknown, log_factors, rng)
        else:
            filtered = model.filter(weights)
        return model.draw(rng, 1, filtered)[0]
