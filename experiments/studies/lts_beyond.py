"""Beyond the LTS paper: pairs rejected whole, redescending fits, re-association, consensus.

Figure `lts_beyond` is drawn from it: every estimator against the bound with failure rates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from experiments.lts_methods import Frame, LtsConfig, bound_sd, draw_frame
from experiments.studies.lts import NAMES
from probreg import ReportProblem
from probreg.estimators import (
    Estimator,
    Irls,
    LeastSquares,
    Lms,
    Lts,
    Mm,
    ReweightedLeastSquares,
)
from probreg.joint import Consensus, Reassociation
from probreg.noise import StudentT
from probreg.sensors.reports import pair_up
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Config(LtsConfig):
    """Noise levels; settings of the methods beyond the paper."""

    sigmas_m: tuple[float, ...] = (40.0, 100.0, 200.0)
    nu: float = 3.0
    last_gate_sigmas: float = 8.0


PROFILES = {"quick": Config(replicates=2), "paper": Config()}
GRID = {"reading": ("literal", "symmetric")}
RELINEARISED = ", exact model"
JOINT = ("re-association", "consensus")
ORACLE = "least squares, right pairs"


def methods(config: Config) -> dict[str, Estimator]:
    """Estimators of paired reports, by name; those of the exact model end in RELINEARISED."""
    lts = Lts(config.coverage, "equation", config.subsets)
    pairwise = ReweightedLeastSquares(config.threshold, lts, "row")
    return {
        "LS": LeastSquares(),
        "LMS": Lms("equation", config.subsets, reweighted=False),
        "LTS": lts,
        "RLS": ReweightedLeastSquares(config.threshold, lts),
        "RLS, whole pairs": pairwise,
        "FAST-LTS": Lts(config.coverage, "equation", config.subsets, concentration=True),
        "MM": Mm(start=Lts(0.5, "row", config.subsets, concentration=True)),
        "Student-t": Irls(StudentT(config.nu), start=lts),
        "RLS, whole pairs" + RELINEARISED: pairwise,
        "Student-t" + RELINEARISED: Irls(StudentT(config.nu), start=lts),
    }


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs at every noise level."""
    seeds = rng.integers(2**62, size=config.runs)
    names = [*methods(config), *JOINT, ORACLE]
    shape = (config.runs, len(config.sigmas_m))
    theta, bound = np.empty((*shape, len(names), 4)), np.empty((*shape, 4))
    wrong, believed = np.empty(shape), np.empty((*shape, len(JOINT)))
    for run, seed in enumerate(seeds):
        for s, sigma in enumerate(config.sigmas_m):
            frame = draw_frame(config, sigma, int(seed))
            theta[run, s], believed[run, s] = _apply(config, frame, int(seed))
            bound[run, s], wrong[run, s] = bound_sd(frame), frame.wrong
    return xr.Dataset(
        {
            "theta": (("run", "sigma", "estimator", "parameter"), theta),
            "bound_sd": (("run", "sigma", "parameter"), bound),
            "wrong_share": (("run", "sigma"), wrong),
            "believed_wrong_share": (("run", "sigma", "joint"), believed),
        },
        {
            "sigma": list(config.sigmas_m),
            "estimator": names,
            "joint": list(JOINT),
            "parameter": list(NAMES),
            "truth": ("parameter", config.scene(0.0).bias),
        },
    )


def _apply(config: Config, frame: Frame, seed: int) -> tuple[FloatArray, list[float]]:
    """Estimates (methods, 4), and the share of wrong pairs that joint methods believe."""
    exact = ReportProblem(frame.paired)
    linear = exact.one_shot()
    theta = []
    for name, method in methods(config).items():
        problem = exact if name.endswith(RELINEARISED) else linear
        theta.append(method.estimate(problem, rng=np.random.default_rng(seed)).theta)
    scene = frame.scene
    spread = np.sqrt(2.0) * scene.sigma_m
    joint = (
        Reassociation(scene.gate_m, config.last_gate_sigmas * spread, objective=scene.objective),
        Consensus(scene.gate_m, scene.objective),
    )
    wrong = []
    for finder in joint:
        estimate = finder.estimate(*frame.data, np.random.default_rng(seed))
        theta.append(estimate.theta)
        pairs = {tuple(pair) for pair in estimate.info["pairs"].tolist()}
        right = {tuple(pair) for pair in frame.truth.right_pairs().tolist()}
        wrong.append(len(pairs - right) / max(len(pairs), 1))
    truth_pairs = pair_up(*frame.data, frame.truth.right_pairs())
    theta.append(LeastSquares().estimate(ReportProblem(truth_pairs)).theta)
    return np.array(theta), wrong
