"""LTS paper (Tian and Huang 2018): LS, LMS, LTS and RLS under nonideal association.

Figures 2-4 are drawn from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.lts_methods import LtsConfig, bound_sd, draw_frame
from probreg import ReportProblem
from probreg.estimators import Estimator, LeastSquares, Lms, Lts, ReweightedLeastSquares
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Config(LtsConfig):
    """Noise levels of experiment 1, and noise level and thresholds of experiment 2."""

    sigmas_m: tuple[float, ...] = (0.0, 40.0, 80.0, 120.0, 160.0, 200.0)
    sweep_sigma_m: float = 100.0
    sweep_thresholds: tuple[float, ...] = tuple(float(k) for k in range(1, 21))


PROFILES = {"quick": Config(replicates=4), "paper": Config()}
GRID = {"reading": ("literal", "symmetric")}
NAMES = ("A.range", "A.azimuth", "B.range", "B.azimuth")


def methods(config: Config) -> dict[str, Estimator]:
    """The paper's estimators, by the name in its figures; RLS also at its best threshold."""
    lts = Lts(config.coverage, "equation", config.subsets)
    return {
        "LS": LeastSquares(),
        "LMS": Lms("equation", config.subsets, reweighted=False),
        "LTS": lts,
        "RLS": ReweightedLeastSquares(config.threshold, lts),
        "RLS, threshold 7": ReweightedLeastSquares(7.0, lts),
    }


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: experiment 1 at every noise level, experiment 2 at every threshold."""
    seeds = rng.integers(2**62, size=config.runs)
    found = methods(config)
    theta = np.empty((config.runs, len(config.sigmas_m), len(found), 4))
    bound = np.empty((config.runs, len(config.sigmas_m), 4))
    wrong = np.empty((config.runs, len(config.sigmas_m)))
    fallback = np.zeros((config.runs, len(config.sigmas_m)), dtype=int)
    sweep = np.empty((config.runs, len(config.sweep_thresholds), 4))
    sweep_wrong = np.empty(config.runs)
    for run, seed in enumerate(seeds):
        for s, sigma in enumerate(config.sigmas_m):
            frame = draw_frame(config, sigma, int(seed))
            problem = ReportProblem(frame.paired).one_shot()
            for k, method in enumerate(found.values()):
                estimate = method.estimate(problem, rng=np.random.default_rng(int(seed)))
                theta[run, s, k] = estimate.theta
                fallback[run, s] += bool(estimate.info.get("fallback", False))
            bound[run, s] = bound_sd(frame) if sigma > 0.0 else 0.0
            wrong[run, s] = frame.wrong
        sweep[run], sweep_wrong[run] = _sweep(config, int(seed))
    dims = ("run", "sigma", "estimator", "parameter")
    values: dict[str, tuple[tuple[str, ...], Any]] = {
        "theta": (dims, theta),
        "bound_sd": (("run", "sigma", "parameter"), bound),
        "wrong_share": (("run", "sigma"), wrong),
        "fallbacks": (("run", "sigma"), fallback),
        "sweep_theta": (("run", "threshold", "parameter"), sweep),
        "sweep_wrong_share": (("run",), sweep_wrong),
    }
    coords = {
        "sigma": list(config.sigmas_m),
        "estimator": list(found),
        "threshold": list(config.sweep_thresholds),
        "parameter": list(NAMES),
        "truth": ("parameter", config.scene(0.0).bias),
    }
    return xr.Dataset({k: (d, np.asarray(v)) for k, (d, v) in values.items()}, coords)


def _sweep(config: Config, seed: int) -> tuple[FloatArray, float]:
    frame = draw_frame(config, config.sweep_sigma_m, seed)
    problem = ReportProblem(frame.paired).one_shot()
    lts = Lts(config.coverage, "equation", config.subsets)
    theta = [
        ReweightedLeastSquares(t, lts).estimate(problem, rng=np.random.default_rng(seed)).theta
        for t in config.sweep_thresholds
    ]
    return np.array(theta), frame.wrong
