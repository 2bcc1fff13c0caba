"""A random walk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.posterior.posterior import Posterior
from probreg.samplers.moves._move import Proposal
from probreg.typing import FloatArray
from probreg.validation import positive_number

TARGET = 0.3  # near the best rate of a random walk in a handful of dimensions


@dataclass(frozen=True)
class LocalGaussian:
    """A Gaussian step about the current state, shaped by the posterior's own covariance.

    Parameters
    ----------
    step : float, optional
        Length of a step in posterior standard deviations along each axis. By default it
        starts at 2.4 / sqrt(d) and is tuned in warm-up; a given step is kept.
    share : float
        How often the move is chosen, relative to the others.
    """

    step: float | None = None
    share: float = 0.2

    def __post_init__(self) -> None:
        positive_number("share of LocalGaussian", self.share)
        if self.step is not None:
            positive_number("step of LocalGaussian", self.step)

    def ready(self, posterior: Posterior, gamma: float) -> Proposal:
        """Take the shape from the Laplace approximation."""
        length = 2.4 / np.sqrt(posterior.dim) if self.step is None else self.step
        root = posterior.laplace.root * length / np.sqrt(gamma)
        return _Walk(root, TARGET if self.step is None else None)


@dataclass(frozen=True, eq=False)
class _Walk:
    root: FloatArray
    target: float | None

    def propose(
        self, x: FloatArray, step: float, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Add a Gaussian step: symmetric, so the ratio is one."""
        return x + step * rng.standard_normal(x.shape) @ self.root.T, np.zeros(len(x))
