"""Robust total-least-squares paper (Wu et al. 2015): RLS, RTLS, XRTLS and RRTLS.

Figures 1-6 and the table are drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.passive_methods import (
    outlier_sizes,
    squared_bound,
    squared_error,
    squared_path,
    total_methods,
)
from probreg import BearingProblem
from probreg.diagnostics import cramer_rao_path
from probreg.scenarios.rrtls import TABLE, RrtlsScene, simulate
from probreg.typing import FloatArray

CONDITIONS = ("none", "table")
SWEPT = ("RTLS", "XRTLS", "RRTLS", "RRTLS, robust start")


@dataclass(frozen=True)
class Config:
    """The paper's numbers; a replicate is a block of runs."""

    replicates: int = 20
    runs: int = 10
    seed: int = 20150317
    r0: float = 1.5
    r1: float = 5.0
    reject: float = 3.0
    rates: tuple[float, ...] = tuple(round(0.01 * k, 2) for k in range(16))
    contamination_size: float = -40.0
    histogram: tuple[float, float, int] = (-70.0, 10.0, 320)

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        scene = dataclasses.asdict(RrtlsScene(outliers=TABLE))
        return {**dataclasses.asdict(self), "scene": scene}


PROFILES = {"quick": Config(replicates=4), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: without and with the table of outliers, and the contamination sweep."""
    methods = total_methods(config.r0, config.r1, config.reject)
    seeds = [int(s) for s in rng.integers(2**62, size=config.runs)]
    low, high, bins = config.histogram
    edges = np.linspace(low, high, bins + 1)
    square, largest = [], []
    counts = np.zeros((len(CONDITIONS), len(methods), bins), dtype=int)
    for seed in seeds:
        for c, table in enumerate(((), TABLE)):
            scene = RrtlsScene(outliers=table)
            data, truth = simulate(scene, np.random.default_rng(seed))
            problem = BearingProblem.of(data)
            found = [method.estimate(problem) for method in methods.values()]
            square.append([squared_path(e, truth.emitter) for e in found])
            left = [problem.line_residuals(e.theta) for e in found]
            largest.append([np.abs(u).max() for u in left])
            # beyond the edges they are counted in the outermost bins
            counts[c] += [np.histogram(np.clip(u, low, high), edges)[0] for u in left]
    shape = (config.runs, len(CONDITIONS), len(methods))
    dims = ("run", "outliers", "estimator")
    bound = cramer_rao_path(problem, truth.emitter)
    values: dict[str, tuple[tuple[str, ...], Any]] = {
        "squared_error": ((*dims, "point"), np.reshape(square, (*shape, -1))),
        "largest_residual": (dims, np.reshape(largest, shape)),
        "residual_counts": (("outliers", "estimator", "bin"), counts),
        "squared_bound": (("point",), squared_bound(bound)),
        "sweep_squared_error": (("run", "rate", "swept"), _sweep(config, seeds)),
        "own": (("point", "axis"), data.own_position),
        "size": (
            ("point",),
            outlier_sizes(simulate, RrtlsScene(outliers=TABLE), RrtlsScene(), seeds[0]),
        ),
    }
    coords = {
        "outliers": list(CONDITIONS),
        "estimator": list(methods),
        "swept": list(SWEPT),
        "rate": list(config.rates),
        "point": 1 + np.arange(len(data)),
        "bin": 0.5 * (edges[1:] + edges[:-1]),
        "axis": ["x", "y"],
        "emitter": ("axis", truth.emitter),
    }
    return xr.Dataset({k: (d, np.asarray(v)) for k, (d, v) in values.items()}, coords)


def _sweep(config: Config, seeds: list[int]) -> FloatArray:
    """Squared error after the last point, by share of outliers: (run, rate, estimator)."""
    methods = total_methods(config.r0, config.r1, config.reject)
    found = np.empty((len(seeds), len(config.rates), len(SWEPT)))
    for k, seed in enumerate(seeds):
        for r, rate in enumerate(config.rates):
            scene = RrtlsScene(contamination=rate, contamination_size=config.contamination_size)
            data, truth = simulate(scene, np.random.default_rng(seed))
            problem = BearingProblem.of(data)
            for m, name in enumerate(SWEPT):
                theta = methods[name].estimate(problem).theta
                found[k, r, m] = squared_error(theta, truth.emitter)
    return found
