"""Calibration of an emitter's position from bearings: exact posterior, and its Laplace form.

Figure `calibration_position` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.bayes_families import PositionFamily, applies, samplers
from probreg.diagnostics import rank_truth
from probreg.typing import FloatArray

LAWS = ("Gaussian", "Student-t", "contaminated", "Laplace")
METHODS = ("MH", "Gibbs", "importance")
PROBABILITIES = (0.5, 0.9)


@dataclass(frozen=True)
class Config:
    """A replicate is a block of runs."""

    replicates: int = 100
    runs: int = 10
    seed: int = 20260104
    keep: int = 99

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return {
            **dataclasses.asdict(self),
            "family": dataclasses.asdict(PositionFamily("Gaussian")),
        }


PROFILES = {"quick": Config(replicates=4, runs=5), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: ranks under each sampler; ellipses of the Laplace form."""
    methods = {name: samplers()[name] for name in METHODS}
    ranks = np.empty((config.runs, len(methods), len(LAWS), 3), dtype=int)
    inside = np.empty((config.runs, len(LAWS), len(PROBABILITIES)))
    for run in range(config.runs):
        for k, law in enumerate(LAWS):
            case = PositionFamily(law)(rng)
            for m, sampler in enumerate(methods.values()):
                assert applies(sampler, case.posterior.noise, ())
                draws = sampler.sample(case.posterior, 1, config.keep, rng)
                ranks[run, m, k], names = rank_truth(draws, case.truth, config.keep, rng)
            laplace = case.posterior.laplace
            z: FloatArray = np.linalg.solve(laplace.root, case.truth - laplace.mean)
            # chi-square of two degrees of freedom in closed form
            inside[run, k] = [z @ z <= -2.0 * np.log(1.0 - p) for p in PROBABILITIES]
    example = _example(config, np.random.default_rng(config.seed))
    return xr.Dataset(
        {
            "ranks": (("run", "sampler", "law", "quantity"), ranks),
            "laplace_inside": (("run", "law", "probability"), inside),
            **example,
        },
        {
            "sampler": list(methods),
            "law": list(LAWS),
            "quantity": list(names),
            "probability": list(PROBABILITIES),
        },
    )


def _example(config: Config, rng: np.random.Generator) -> dict[str, Any]:
    """One posterior on a grid, with draws: the same in every replicate."""
    case = PositionFamily("Student-t", bearings=6)(rng)
    laplace = case.posterior.laplace
    draws = samplers()["MH"].sample(case.posterior, 8, 50, rng)
    reach = 4.5 * np.sqrt(np.diag(laplace.covariance))
    x = laplace.mean[0] + reach[0] * np.linspace(-0.7, 1.0, 101)
    y = laplace.mean[1] + reach[1] * np.linspace(-0.7, 1.0, 101)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    density = case.posterior.log_prob(grid)
    return {
        "grid_x": ("grid_i", x),
        "grid_y": ("grid_j", y),
        "log_density": (("grid_i", "grid_j"), density - density.max()),
        "example_draws": (("draw", "axis"), draws.flat),
        "example_mode": ("axis", laplace.mean),
        "example_covariance": (("axis", "axis2"), laplace.covariance),
        "example_truth": ("axis", case.truth),
    }
