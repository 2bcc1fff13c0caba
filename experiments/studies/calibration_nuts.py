"""Simulation-based calibration of NUTS under every proper law, two geometries.

Figure `calibration_sbc` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.bayes_families import LAWS, LinearFamily, nuts
from experiments.studies.calibration import ABSENT, QUANTITIES
from probreg.diagnostics import rank_truth


@dataclass(frozen=True)
class Config:
    """A replicate is a block of runs; every third of 3 x `keep` draws is kept."""

    geometry: str = "pair_2d"
    replicates: int = 100
    runs: int = 2
    seed: int = 20260102
    rows: int = 100
    keep: int = 99

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        laws = {name: repr(law) for name, law in LAWS.items()}
        return {**dataclasses.asdict(self), "sampler": repr(nuts()), "laws": laws}


PROFILES = {"quick": Config(replicates=2, runs=1, keep=33), "paper": Config()}
GRID = {"geometry": ("pair_2d", "pair_3d")}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs of every law."""
    ranks = np.full((config.runs, 1, len(LAWS), QUANTITIES), ABSENT)
    for run in range(config.runs):
        for k, law in enumerate(LAWS):
            case = LinearFamily(config.geometry, law, config.rows)(rng)
            draws = nuts().sample(case.posterior, 3 * config.keep, 1, rng)
            found, _ = rank_truth(draws, case.truth, config.keep, rng)
            ranks[run, 0, k, : len(found)] = found
    return xr.Dataset(
        {"ranks": (("run", "sampler", "law", "quantity"), ranks)},
        {"sampler": ["NUTS"], "law": list(LAWS), "quantity": np.arange(QUANTITIES)},
    )
