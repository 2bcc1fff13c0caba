"""Robust EKF paper (Zhang et al. 2014): LS, EKF, robust EKF and its chi-square gated form.

Figures 1-4 and the tables are drawn from it.
"""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.passive_methods import (
    filter_methods,
    outlier_sizes,
    squared_bound,
    squared_path,
)
from probreg import BearingProblem, GaussianPrior
from probreg.diagnostics import cramer_rao_path
from probreg.estimators import Estimator
from probreg.scenarios.rekf import READINGS, RekfScene, simulate
from probreg.typing import FloatArray

TIMED = ("EKF", "REKF", "chi2-REKF")


@dataclass(frozen=True)
class Config:
    """The paper's numbers; a replicate is a block of runs.

    `dense_interval_s` is that of the long recordings on which a pass is timed.
    """

    sigma_deg: float = 0.1
    replicates: int = 20
    runs: int = 10
    seed: int = 20140418
    k1: float = 1.2
    k2: float = 4.0
    gate: float = 7.879
    start_bearings: int = 5
    dense_interval_s: float = 0.01

    def scene(self, reading: Any) -> RekfScene:
        """The scene under one reading of the outlier table."""
        return RekfScene(self.sigma_deg, reading)

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return {**dataclasses.asdict(self), "scene": dataclasses.asdict(self.scene("none"))}


PROFILES = {"quick": Config(replicates=4), "paper": Config()}
GRID = {"sigma_deg": (0.1, 1.0)}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: every reading of the outliers, every estimator, the same noise."""
    methods = filter_methods(config.k1, config.k2, config.gate, config.start_bearings)
    seeds = rng.integers(2**62, size=config.runs)
    square, passes, rejected, theta = [], [], [], []
    for seed in seeds:
        for reading in READINGS:
            data, truth = simulate(config.scene(reading), np.random.default_rng(int(seed)))
            problem = BearingProblem.of(data)
            found = [method.estimate(problem) for method in methods.values()]
            square.append([squared_path(e, truth.emitter) for e in found])
            counts = [e.info.get("passes", np.zeros(1, dtype=int)) for e in found]
            passes.append([float(np.mean(c)) for c in counts])
            rejected.append([int(e.info.get("rejected", 0)) for e in found])
            theta.append([e.theta for e in found])
    bound = cramer_rao_path(problem, truth.emitter)
    struck = config.scene("one_sided"), config.scene("none")
    shape = (config.runs, len(READINGS), len(methods))
    dims = ("run", "outliers", "estimator")
    values: dict[str, tuple[tuple[str, ...], Any]] = {
        "squared_error": ((*dims, "time"), np.reshape(square, (*shape, -1))),
        "passes": (dims, np.reshape(passes, shape)),
        "rejected": (dims, np.reshape(rejected, shape)),
        "theta": ((*dims, "axis"), np.reshape(theta, (*shape, 2))),
        "squared_bound": (("time",), squared_bound(bound)),
        "bound": (("axis", "axis2"), bound[-1]),
        "own": (("time", "axis"), data.own_position),
        "bearing": (("time",), data.bearing),
        "size": (("time",), outlier_sizes(simulate, *struck, int(seeds[0]))),
        "seconds_pass": (
            ("outliers", "timed"),
            _seconds({name: methods[name] for name in TIMED}, config, int(seeds[0])),
        ),
    }
    coords = {
        "outliers": list(READINGS),
        "estimator": list(methods),
        "timed": list(TIMED),
        "time": data.time,
        "axis": ["x", "y"],
        "emitter": ("axis", truth.emitter),
    }
    return xr.Dataset({k: (d, np.asarray(v)) for k, (d, v) in values.items()}, coords)


def _seconds(methods: dict[str, Estimator], config: Config, seed: int) -> FloatArray:
    """Time of a pass over 200 bearings: from a recording so long that checks do not count."""
    found = np.empty((len(READINGS), len(methods)))
    for r, reading in enumerate(READINGS):
        scene = dataclasses.replace(config.scene(reading), interval_s=config.dense_interval_s)
        data, truth = simulate(scene, np.random.default_rng(seed))
        problem = BearingProblem.of(data)
        start = GaussianPrior.from_sd(np.full(2, 1e3), truth.emitter + 200.0)
        for m, method in enumerate(methods.values()):
            times = []
            for _ in range(3):
                began = time.perf_counter()
                method.estimate(problem, start)
                times.append(time.perf_counter() - began)
            found[r, m] = 200.0 * min(times) / len(problem)
    return found
