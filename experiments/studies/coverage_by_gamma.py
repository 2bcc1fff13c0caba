"""What sharpening does to credible intervals: coverage against gamma.

Figure `coverage_by_gamma` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.bayes_families import LinearFamily
from probreg.samplers import MetropolisHastings


@dataclass(frozen=True)
class Config:
    """A replicate is a block of runs."""

    replicates: int = 40
    runs: int = 25
    seed: int = 20260105
    gammas: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0, 10.0)
    probabilities: tuple[float, ...] = (0.5, 0.9)
    num_draws: int = 60
    num_chains: int = 40

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return dataclasses.asdict(self)


PROFILES = {"quick": Config(replicates=4, runs=10), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: how many of the four biases each interval holds."""
    shape = (config.runs, len(config.gammas), len(config.probabilities))
    held = np.empty(shape, dtype=int)
    for run in range(config.runs):
        case = LinearFamily("pair_2d", "Gaussian")(rng)
        for g, gamma in enumerate(config.gammas):
            sampler = MetropolisHastings(gamma=gamma, warmup=20)
            draws = sampler.sample(case.posterior, config.num_draws, config.num_chains, rng)
            for k, probability in enumerate(config.probabilities):
                low, high = draws.interval(probability).T
                held[run, g, k] = np.sum((low <= case.truth) & (case.truth <= high))
    return xr.Dataset(
        {"held": (("run", "gamma", "probability"), held)},
        {
            "gamma": list(config.gammas),
            "probability": list(config.probabilities),
            "unknowns": len(case.truth),
        },
    )
