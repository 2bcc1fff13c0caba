"""RALAD paper (Guo et al. 2017): RLS, Huber, LMedS and RALAD on its two cases.

Figures 1-8 and Tables 2-6 are drawn from it.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from experiments.ralad_methods import (
    READINGS,
    RaladConfig,
    fit,
    labelled,
    readings,
    recursive_methods,
)
from probreg.estimators import Lms, Recursive
from probreg.estimators.recursive import innovation_covariances
from probreg.problems.linear import LinearProblem
from probreg.scenarios.ralad import simulate
from probreg.typing import FloatArray

Config = RaladConfig
PROFILES = {"quick": Config(replicates=12), "paper": Config()}
GRID = {"case": (1, 2)}
TRACKS = ("without parallel track", "with parallel track")


def replicate(config: RaladConfig, rng: np.random.Generator) -> xr.Dataset:
    """Simulate one run and apply every method of the paper under every reading of B and R."""
    data, truth = simulate(config.scene, rng)
    problems = readings(data, truth, config.smoothing_window)
    recursive = recursive_methods(config)
    lms = Lms("row", config.lms_subsets)
    lms_seed = int(rng.integers(2**31))
    found = [
        _apply(problems[reading], recursive, lms, lms_seed, config.scene.targets)
        for reading in READINGS
    ]
    theta, sd, paths, seconds = zip(*found, strict=True)
    names = list(recursive)
    values: dict[str, tuple[tuple[str, ...], Any]] = {
        "theta": (("reading", "estimator", "parameter"), theta),
        "claimed_sd": (("reading", "estimator", "parameter"), sd),
        "path": (("reading", "recursion", "scan", "parameter"), paths),
        "seconds": (("reading", "timed"), seconds),
        "theta_single_shift": (
            ("recursion", "parameter"),
            _single_precision_shift(config, problems["true"]),
        ),
        **_conditions(config, problems["true"]),
    }
    return labelled(
        values,
        reading=list(READINGS),
        estimator=[*names, "LMedS raw", "LMedS"],
        recursion=names,
        timed=[*names, "LMedS"],
        parameter=list(problems["true"].names),
        track=list(TRACKS),
        truth=("parameter", truth.bias),
    )


def _apply(
    problem: LinearProblem,
    recursive: dict[str, Recursive],
    lms: Lms,
    lms_seed: int,
    targets: int,
) -> tuple[list[FloatArray], list[FloatArray], list[FloatArray], list[float]]:
    """Final estimates, claimed standard deviations, paths by scan and times of all methods."""
    problem.whitened()  # shared by all methods, so not part of their times
    finals, claims, paths, seconds = [], [], [], []
    for method in recursive.values():
        began = time.perf_counter()
        estimate, claim = fit(method, problem, np.random.default_rng(lms_seed))
        seconds.append(time.perf_counter() - began)
        assert estimate.path is not None
        finals.append(estimate.theta)
        claims.append(claim)
        paths.append(estimate.path[targets - 1 :: targets])
    began = time.perf_counter()
    median, claim = fit(lms, problem, np.random.default_rng(lms_seed))
    seconds.append(time.perf_counter() - began)
    finals += [median.info["raw"], median.theta]
    claims += [np.full_like(claim, np.nan), claim]
    return finals, claims, paths, seconds


def _single_precision_shift(config: RaladConfig, problem: LinearProblem) -> list[np.ndarray]:
    """What single precision changes in the final estimates: the paper's stability claim."""
    shifts = []
    for method in recursive_methods(config).values():
        double = method.estimate(problem).theta
        shifts.append(replace(method, precision="single").estimate(problem).theta - double)
    return shifts


def _conditions(
    config: RaladConfig, problem: LinearProblem
) -> dict[str, tuple[tuple[str, ...], Any]]:
    """Log10 ratios of condition numbers along a track of either kind, each method with its own P.

    The paper shows "the first track" without saying whether it has a parallel one; exchanged
    reports make that the difference.
    """
    methods = recursive_methods(config)
    fits = {
        name: replace(methods[name], covariance_path=True).estimate(problem)
        for name in ("Huber", "RALAD")
    }
    printed, own = [], []
    for first in (config.scene.pairs, 0):
        rows = slice(first, None, config.scene.targets)
        spread_h, noise_h = innovation_covariances(fits["Huber"], problem, config.omega, rows)
        spread_r, noise_r = innovation_covariances(fits["RALAD"], problem, config.omega, rows)
        huber = np.linalg.cond(spread_h + noise_h)
        printed.append(np.log10(huber / np.linalg.cond(spread_r + problem.R[rows])))
        own.append(np.log10(huber / np.linalg.cond(spread_r + noise_r)))
    return {
        "log_condition_ratio": (("track", "scan"), printed),
        "log_condition_ratio_own_noise": (("track", "scan"), own),
    }
