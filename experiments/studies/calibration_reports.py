"""Calibration of the whole chain: polar reports drawn, converted, re-linearised, sampled.

Figure `calibration_reports` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.bayes_families import ReportFamily
from probreg.diagnostics import rank_truth
from probreg.noise import Gaussian
from probreg.samplers import Exact, Importance, Sampler

NOISES = {"Gaussian": float("inf"), "Student-t": 8.0}


@dataclass(frozen=True)
class Config:
    """A replicate is a block of runs of one number of reports."""

    reports: int = 500
    replicates: int = 100
    runs: int = 10
    seed: int = 20260103
    keep: int = 99

    @property
    def block(self) -> int:
        """Runs in a replicate: fewer where there are many reports."""
        return self.runs if self.reports < 10_000 else max(1, self.runs // 5)

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        family = dataclasses.asdict(ReportFamily(self.reports))
        return {**dataclasses.asdict(self), "block": self.block, "family": family}


PROFILES = {"quick": Config(replicates=2, runs=5), "paper": Config()}
GRID = {"reports": (500, 50_000)}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs under Gaussian and Student-t noise."""
    ranks = np.empty((config.block, len(NOISES), 7), dtype=int)
    for run in range(config.block):
        for k, nu in enumerate(NOISES.values()):
            case = ReportFamily(config.reports, nu)(rng)
            gaussian = isinstance(case.posterior.noise, Gaussian)
            sampler: Sampler = Exact() if gaussian else Importance(oversample=4.0)
            draws = sampler.sample(case.posterior, 1, config.keep, rng)
            ranks[run, k], names = rank_truth(draws, case.truth, config.keep, rng)
    return xr.Dataset(
        {"ranks": (("run", "law", "quantity"), ranks)},
        {"law": list(NOISES), "quantity": list(names)},
    )
