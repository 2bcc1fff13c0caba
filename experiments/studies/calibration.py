"""Simulation-based calibration: every sampler under every proper law, two geometries.

Figure `calibration_sbc` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.bayes_families import LAWS, LinearFamily, applies, samplers
from probreg.diagnostics import rank_truth

QUANTITIES = 10  # the most unknowns (six biases, three of the law) and the log-likelihood
ABSENT = -1


@dataclass(frozen=True)
class Config:
    """A replicate is a block of runs; the truth is ranked among `keep` draws."""

    geometry: str = "pair_2d"
    replicates: int = 100
    runs: int = 10
    seed: int = 20260101
    rows: int = 100
    keep: int = 99

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        methods = {name: repr(sampler) for name, sampler in samplers().items()}
        laws = {name: repr(law) for name, law in LAWS.items()}
        return {**dataclasses.asdict(self), "samplers": methods, "laws": laws}


PROFILES = {"quick": Config(replicates=4, runs=4), "paper": Config()}
GRID = {"geometry": ("pair_2d", "pair_3d")}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs of every sampler and law that go together."""
    methods = samplers()
    shape = (config.runs, len(methods), len(LAWS), QUANTITIES)
    ranks = np.full(shape, ABSENT)
    for run in range(config.runs):
        for k, (law, (noise, unknown)) in enumerate(LAWS.items()):
            case = LinearFamily(config.geometry, law, config.rows)(rng)
            for m, sampler in enumerate(methods.values()):
                if applies(sampler, noise, unknown):
                    draws = sampler.sample(case.posterior, 1, config.keep, rng)
                    found, _ = rank_truth(draws, case.truth, config.keep, rng)
                    ranks[run, m, k, : len(found)] = found
    return xr.Dataset(
        {"ranks": (("run", "sampler", "law", "quantity"), ranks)},
        {"sampler": list(methods), "law": list(LAWS), "quantity": np.arange(QUANTITIES)},
    )
