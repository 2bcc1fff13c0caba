"""What a path sampler returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from probreg import arviz_adapter
from probreg.arviz_adapter import Convergence
from probreg.errors import InvalidInputError
from probreg.numerics.intervals import equal_tailed
from probreg.posterior.path_posterior import PathPosterior
from probreg.typing import FloatArray
from probreg.validation import sampling_run


class PathSampler(Protocol):
    """What studies and conformance tests ask of a sampler of paths."""

    def sample(
        self, posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> PathDraws:
        """Draw whole paths."""


@dataclass(frozen=True, eq=False)
class PathDraws:
    """Draws of whole paths.

    Attributes
    ----------
    posterior : PathPosterior
    path : ndarray, shape (chain, draw, T, d)
    stats : mapping of str to ndarray, shape (chain, draw)
    sampler : str
    facts : mapping
        Of the run: acceptance, step.
    step_scale : ndarray, shape (chain, draw, k), optional
        Factors on the process noise that were sampled too.
    """

    posterior: PathPosterior
    path: FloatArray
    stats: Mapping[str, FloatArray]
    sampler: str
    facts: Mapping[str, Any] = field(default_factory=dict)
    step_scale: FloatArray | None = None

    @property
    def mean(self) -> FloatArray:
        """Posterior mean of the path, shape (T, d)."""
        return self.path.mean(axis=(0, 1))

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations, shape (T, d)."""
        return self.path.std(axis=(0, 1))

    def interval(self, probability: float) -> FloatArray:
        """Equal-tailed credible intervals, shape (T, d, 2)."""
        return equal_tailed(self.path, probability, (0, 1))

    @cached_property
    def convergence(self) -> Convergence:
        """R-hat, effective sample sizes, Monte-Carlo errors of every scan and state, (T * d,)."""
        chains, draws = self.path.shape[:2]
        return arviz_adapter.convergence(self.path.reshape(chains, draws, -1))

    def to_arviz(self) -> Any:
        """InferenceData (ArviZ before 1.0) or DataTree: "path" by time and state."""
        time = self.posterior.trajectory.time
        coords = {"state": list(self.posterior.names)}
        if time is not None:
            coords["time"] = list(time)
        groups = {"posterior": {"path": self.path}}
        if self.step_scale is not None and self.step_scale.shape[-1]:
            groups["posterior"]["step_scale"] = self.step_scale
        if self.stats:
            groups["sample_stats"] = dict(self.stats)
        return arviz_adapter.inference_data(
            groups, coords, {"path": ["time", "state"]}, {"sampler": self.sampler}
        )


def require_paths(
    posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
) -> None:
    """Raise unless the numbers make sense."""
    if not isinstance(posterior, PathPosterior):
        raise InvalidInputError(f"takes a PathPosterior, not a {type(posterior).__name__}.")
    sampling_run(num_draws, num_chains, rng)
