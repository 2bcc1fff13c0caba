"""Beyond the bearings-only papers: maximum likelihood under robust laws, and a biased sensor.

Figure `passive_beyond` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.passive_methods import filter_methods, squared_bound, squared_error, total_methods
from probreg import BearingProblem, BearingReports, UnobservableError
from probreg.diagnostics import cramer_rao_bound
from probreg.estimators import Estimator, Irls, LeastSquares
from probreg.noise import Contaminated, StudentT
from probreg.scenarios import rekf, rrtls
from probreg.typing import FloatArray

Draw = Callable[[np.random.Generator], tuple[BearingReports, Any]]


@dataclass(frozen=True)
class Config:
    """Settings of the laws; a replicate is a block of runs."""

    replicates: int = 20
    runs: int = 10
    seed: int = 20261101
    nu: float = 4.0
    rate: float = 0.1
    scale: float = 15.0
    bias_deg: float = 0.3
    contamination: float = 0.13
    bearings: tuple[int, ...] = (50, 100, 150, 200)

    def scenes(self) -> dict[str, tuple[Any, Any]]:
        """Scenario module and scene by name."""
        filtered, total = rekf.RekfScene, rrtls.RrtlsScene
        return {
            "passing, clean": (rekf, filtered()),
            "passing, random outliers": (rekf, filtered(outliers="random")),
            "passing, one-sided outliers": (rekf, filtered(outliers="one_sided")),
            "passing, one-sided, biased": (
                rekf,
                filtered(outliers="one_sided", bias_deg=self.bias_deg),
            ),
            "distant, clean": (rrtls, total()),
            "distant, outliers": (rrtls, total(outliers=rrtls.TABLE)),
            "distant, contaminated": (rrtls, total(contamination=self.contamination)),
        }

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        scenes = {name: dataclasses.asdict(scene) for name, (_, scene) in self.scenes().items()}
        return {**dataclasses.asdict(self), "scenes": scenes}


PROFILES = {"quick": Config(replicates=2, runs=8), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}
ELLIPSE = 4.605  # chi-square of two degrees of freedom, 90 %
MISSING = float("nan")


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: every scene, every estimator that it is for, after 50 to 200 bearings."""
    methods = _methods(config)
    scenes = config.scenes()
    shape = (config.runs, len(scenes), len(methods), len(config.bearings))
    square, inside = np.full(shape, MISSING), np.full(shape, MISSING)
    bound = np.empty((len(scenes), 2, len(config.bearings)))
    for run, seed in enumerate(rng.integers(2**62, size=config.runs)):
        for s, (name, (module, scene)) in enumerate(scenes.items()):
            data, truth = module.simulate(scene, np.random.default_rng(int(seed)))
            problem = BearingProblem.of(data)
            for b, count in enumerate(config.bearings):
                part = problem.part(slice(count))
                for m, asked in enumerate(methods.values()):
                    if name.startswith(asked.scene):
                        found = _score(asked, part, truth.emitter)
                        square[run, s, m, b], inside[run, s, m, b] = found
            if run == 0:
                bound[s] = [_bounds(problem, truth, config.bearings, u) for u in (False, True)]
    dims = ("run", "scene", "estimator", "bearings")
    return xr.Dataset(
        {
            "squared_error": (dims, square),
            "inside": (dims, inside),
            "squared_bound": (("scene", "unknown", "bearings"), bound),
        },
        {
            "scene": list(scenes),
            "estimator": list(methods),
            "bearings": list(config.bearings),
            "unknown": ["position", "position and bias"],
        },
    )


@dataclass(frozen=True)
class _Asked:
    """An estimator, the scenes it is for, and whether the sensor's bias is an unknown of its."""

    estimator: Estimator
    scene: str = ""
    sensor_bias: bool = False


def _methods(config: Config) -> dict[str, _Asked]:
    filters, totals = filter_methods(1.2, 4.0, 7.879, 5), total_methods(1.5, 5.0, 3.0)
    student, mixed = Irls(StudentT(config.nu)), Irls(Contaminated(config.rate, config.scale))
    return {
        "EKF": _Asked(filters["EKF"], "passing"),
        "chi2-REKF": _Asked(filters["chi2-REKF"], "passing"),
        "RTLS": _Asked(totals["RTLS"], "distant"),
        "RRTLS": _Asked(totals["RRTLS"], "distant"),
        "RRTLS, robust start": _Asked(totals["RRTLS, robust start"], "distant"),
        "Gaussian ML": _Asked(LeastSquares()),
        "Student-t ML": _Asked(student),
        "contaminated ML": _Asked(mixed),
        "Student-t ML, bias unknown": _Asked(student, "passing", True),
        "contaminated ML, bias unknown": _Asked(mixed, "passing", True),
    }


def _score(asked: _Asked, problem: BearingProblem, emitter: FloatArray) -> tuple[float, float]:
    """Squared error, infinite without an estimate, and whether the 90 % ellipse holds the truth."""
    problem = dataclasses.replace(problem, sensor_bias=asked.sensor_bias)
    try:
        estimate = asked.estimator.estimate(problem)
    except UnobservableError:  # the likelihood grows all the way to infinity
        return float("inf"), 0.0
    # where the law is meant to hold, its own covariance and not the sandwich
    covariance = estimate.info.get("laplace_covariance", estimate.covariance)
    if covariance is None:
        return squared_error(estimate.theta, emitter), MISSING
    gap = estimate.theta[:2] - emitter
    length = float(gap @ np.linalg.solve(covariance[:2, :2], gap))
    return squared_error(estimate.theta, emitter), float(length <= ELLIPSE)


def _bounds(
    problem: BearingProblem, truth: Any, counts: tuple[int, ...], sensor_bias: bool
) -> list[float]:
    """Bound from the bearings that are no outliers, without noise in the geometry."""
    found = []
    for count in counts:
        good = np.flatnonzero(~truth.outlier[:count])
        part = dataclasses.replace(problem.part(good), sensor_bias=sensor_bias)
        theta = np.append(truth.emitter, truth.bias)[: len(part.names)]
        if sensor_bias and not part.observability(theta).complete:
            found.append(MISSING)
        else:
            found.append(float(squared_bound(cramer_rao_bound(part, theta))))
    return found
