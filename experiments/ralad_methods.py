"""What the RALAD studies share: their settings, the readings of B and R, the estimators."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.study import StudyError
from probreg import ReportProblem
from probreg.estimators import Estimate, Estimator, Recursive
from probreg.noise import Gaussian, Huber, Hyperbolic
from probreg.problems.linear import LinearProblem, Problem
from probreg.scenarios.ralad import CASES, RaladScene, RaladTruth
from probreg.sensors.reports import AssociatedReports, smoothed_positions
from probreg.typing import FloatArray

READINGS = ("true", "smooth", "measured")


@dataclass(frozen=True)
class RaladConfig:
    """Settings of the paper's experiment; the scene follows from the case.

    Case 0 is the clean scene (no exchange, no outlier), not in the paper.
    """

    case: int = 1
    replicates: int = 100
    seed: int = 20170913
    mu: float = 1e-3
    beta: float = 1.345
    omega: float = 1e6
    lms_subsets: int = 200
    smoothing_window: int = 21

    def __post_init__(self) -> None:
        if self.case not in CASES:
            raise StudyError(f"case {self.case} does not exist; known: {sorted(CASES)}.")

    @property
    def scene(self) -> RaladScene:
        """Every number of the simulated scene."""
        return CASES[self.case]

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return {**dataclasses.asdict(self), "scene": dataclasses.asdict(self.scene)}


def readings(data: AssociatedReports, truth: RaladTruth, window: int) -> dict[str, LinearProblem]:
    """The one-shot linear problem with B and R evaluated in three ways.

    "true": at the noise-free position (the letter of equation 4; needs truth); "smooth": at
    the running median of the sensor's own track; "measured": at the raw report.
    """
    problem = ReportProblem(data)
    return {
        "true": problem.one_shot([truth.positions]),
        "smooth": problem.one_shot([smoothed_positions(data, window)]),
        "measured": problem.one_shot(),
    }


def recursive_methods(config: RaladConfig) -> dict[str, Recursive]:
    """The paper's three recursions and its piecewise form (42), by the name in the figures."""
    mu, beta, omega = config.mu, config.beta, config.omega
    return {
        "RLS": Recursive(Gaussian(), omega),
        "Huber": Recursive(Huber(beta, componentwise=True), omega),
        "RALAD": Recursive(Hyperbolic(mu), omega),
        "RALAD (42)": Recursive(Hyperbolic(mu, beta), omega),
    }


def fit(
    method: Estimator, problem: Problem, rng: np.random.Generator
) -> tuple[Estimate, FloatArray]:
    """Estimate and claimed standard deviations (NaN where none is claimed)."""
    estimate = method.estimate(problem, rng=rng)
    sd = np.full(estimate.theta.size, np.nan) if estimate.sd is None else estimate.sd
    return estimate, sd


def labelled(values: dict[str, tuple[tuple[str, ...], object]], **coords: object) -> xr.Dataset:
    """Build a dataset from (dims, array) pairs."""
    return xr.Dataset({k: (dims, np.asarray(v)) for k, (dims, v) in values.items()}, coords)
