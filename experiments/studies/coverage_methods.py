"""Do claimed intervals cover? RLS, RALAD's P, the sandwich, and posteriors under each law.

Figure `coverage_methods` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.lts_methods import LtsConfig, draw_frame
from experiments.ralad_methods import readings
from probreg import GaussianPrior, Posterior, ReportProblem
from probreg.diagnostics import normal_interval
from probreg.estimators import Estimator, Irls, LeastSquares, Recursive
from probreg.noise import Contaminated, Gaussian, Hyperbolic, NoiseLaw, StudentT
from probreg.prior import NoiseParameter
from probreg.problems.linear import LinearProblem
from probreg.samplers import Importance
from probreg.scenarios.ralad import CASES, RaladScene, simulate
from probreg.typing import FloatArray

SCALE = NoiseParameter("scale", 1.0, 0.5)
POSTERIORS: dict[str, tuple[NoiseLaw, tuple[NoiseParameter, ...]]] = {
    "posterior, Gaussian": (Gaussian(), ()),
    "posterior, Laplace": (Hyperbolic(), ()),
    "posterior, Laplace, scale unknown": (Hyperbolic(), (SCALE,)),
    "posterior, Student-t, nu and scale unknown": (
        StudentT(3.0),
        (NoiseParameter("nu", 3.0, 0.7), SCALE),
    ),
    "posterior, contaminated, rate and scale unknown": (
        Contaminated(0.3, 30.0),
        (NoiseParameter("rate", 0.3, 0.7), NoiseParameter("scale", 30.0, 0.7)),
    ),
}
CLAIMED: dict[str, Estimator] = {
    "RLS, its P": Recursive(Gaussian()),
    "RALAD, its P": Recursive(Hyperbolic()),
    "least squares, its covariance": LeastSquares(),
    "batch LAD, sandwich": Irls(Hyperbolic()),
    "Student-t, sandwich": Irls(StudentT(3.0)),
}


@dataclass(frozen=True)
class Config:
    """RALAD case 1 with fewer scans over the same flight; LTS frames of the symmetric reading."""

    data: str = "ralad"
    replicates: int = 100
    runs: int = 4
    seed: int = 20260106
    scans: int = 80
    sigma_m: float = 100.0
    draws: int = 400
    probabilities: tuple[float, ...] = (0.5, 0.9)

    @property
    def scene(self) -> RaladScene:
        """Case 1, its scans spread over the same flight."""
        return CASES[1].in_scans(self.scans)

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return {**dataclasses.asdict(self), "scene": dataclasses.asdict(self.scene)}


PROFILES = {"quick": Config(replicates=4, runs=2), "paper": Config()}
GRID = {"data": ("ralad", "lts")}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: whether each interval of each method holds each bias, and its width."""
    names = [*CLAIMED, *POSTERIORS]
    held, width = [], []
    for _ in range(config.runs):
        problem, prior, truth = _draw(config, rng)
        intervals = [_claimed(method, problem, config) for method in CLAIMED.values()]
        for noise, unknown in POSTERIORS.values():
            posterior = Posterior(problem, noise, prior, unknown)
            draws = Importance(oversample=2.0).sample(posterior, config.draws, 1, rng)
            own = [draws.interval(p)[: len(truth)] for p in config.probabilities]
            intervals.append(np.array(own))
        low, high = np.moveaxis(np.array(intervals), -1, 0)
        held.append((low <= truth) & (truth <= high))
        width.append(high - low)
    dims = ("run", "method_name", "probability", "parameter")
    return xr.Dataset(
        {"held": (dims, np.array(held).astype(int)), "width": (dims, np.array(width))},
        {
            "method_name": names,
            "probability": list(config.probabilities),
            "parameter": list(problem.names),
        },
    )


def _draw(
    config: Config, rng: np.random.Generator
) -> tuple[LinearProblem, GaussianPrior, FloatArray]:
    """One data set as a linear problem, the default prior, and the true biases."""
    if config.data == "ralad":
        data, truth = simulate(config.scene, rng)
        prior = GaussianPrior.default(ReportProblem(data))
        return readings(data, truth, 21)["true"], prior, truth.bias
    frame = draw_frame(LtsConfig(reading="symmetric"), config.sigma_m, int(rng.integers(2**62)))
    problem = ReportProblem(frame.paired)
    return problem.one_shot(), GaussianPrior.default(problem), frame.truth.bias


def _claimed(method: Estimator, problem: LinearProblem, config: Config) -> FloatArray:
    """Intervals (probability, p, 2) from an estimate and the covariance it claims."""
    estimate = method.estimate(problem)
    covariance = estimate.covariance
    if covariance is None:  # no curvature: it claims nothing, and holds nothing
        covariance = np.zeros((len(estimate.theta),) * 2)
    return np.array([normal_interval(estimate.theta, covariance, p) for p in config.probabilities])
