"""The posterior of the six biases on one RALAD data set, under each law, beside RLS and RALAD.

Figure `posterior_ralad` is drawn from it.
"""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.ralad_methods import readings
from probreg import GaussianPrior, LinearProblem, Posterior, ReportProblem
from probreg.diagnostics import compare_laws, outlier_probability
from probreg.estimators import Recursive
from probreg.noise import Contaminated, Gaussian, Hyperbolic, NoiseLaw, StudentT
from probreg.prior import NoiseParameter
from probreg.samplers import Draws, Importance
from probreg.scenarios.ralad import CASES, RaladScene, simulate
from probreg.typing import IntArray

LAWS: dict[str, tuple[NoiseLaw, tuple[NoiseParameter, ...]]] = {
    "Gaussian": (Gaussian(), ()),
    "Laplace": (Hyperbolic(), (NoiseParameter("scale", 1.0, 0.5),)),
    "Student-t": (
        StudentT(3.0),
        (NoiseParameter("nu", 3.0, 0.7), NoiseParameter("scale", 1.0, 0.5)),
    ),
    "contaminated": (
        Contaminated(0.3, 30.0),
        (NoiseParameter("rate", 0.3, 0.7), NoiseParameter("scale", 30.0, 0.7)),
    ),
}
POINTS = {"RLS": Recursive(Gaussian()), "RALAD": Recursive(Hyperbolic())}


@dataclass(frozen=True)
class Config:
    """One data set of case 1, with B and R at the true positions as in the paper's text."""

    replicates: int = 1
    seed: int = 20170914
    scans: int = 800
    draws: int = 1000
    compared_rows: int = 1500
    compared_draws: int = 400

    @property
    def scene(self) -> RaladScene:
        """Case 1, its scans spread over the same flight."""
        return CASES[1].in_scans(self.scans)

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        laws = {name: repr(law) for name, law in LAWS.items()}
        return {**dataclasses.asdict(self), "scene": dataclasses.asdict(self.scene), "laws": laws}


PROFILES = {"quick": Config(scans=80, draws=400, compared_rows=400), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """Sample each posterior; compare the laws on some rows; mark the outliers."""
    data, truth = simulate(config.scene, rng)
    problem = readings(data, truth, 21)["true"]
    prior = GaussianPrior.default(ReportProblem(data))
    theta = np.empty((len(LAWS), config.draws, 6))
    seconds, pareto, found = np.empty(len(LAWS)), np.empty(len(LAWS)), {}
    for k, (name, (noise, unknown)) in enumerate(LAWS.items()):
        began = time.perf_counter()
        draws = Importance(oversample=2.0).sample(
            Posterior(problem, noise, prior, unknown), config.draws // 4, 4, rng
        )
        seconds[k] = time.perf_counter() - began
        theta[k], pareto[k] = draws.flat[:, :6], draws.facts["pareto_k"]
        found[name] = draws
    some = rng.choice(len(problem.y), min(config.compared_rows, len(problem.y)), replace=False)
    elpd, behind, error = _compare(found, problem, some, config.compared_draws // 4)
    points = [method.estimate(problem) for method in POINTS.values()]
    return xr.Dataset(
        {
            "theta": (("law", "draw", "parameter"), theta),
            "pareto_k": (("law",), pareto),
            "elpd": (("law",), elpd),
            "behind": (("law",), behind),
            "behind_error": (("law",), error),
            "point": (("estimator", "parameter"), [e.theta for e in points]),
            "point_sd": (("estimator", "parameter"), [e.sd for e in points]),
            "outlier_probability": (("row",), outlier_probability(found["contaminated"])),
            "clean": (("row",), truth.clean.astype(int)),
            "seconds": (("law",), seconds),
        },
        {
            "law": list(LAWS),
            "estimator": list(POINTS),
            "parameter": list(problem.names),
            "truth": ("parameter", truth.bias),
        },
    )


def _compare(
    found: dict[str, Draws], problem: LinearProblem, some: IntArray, draws: int
) -> tuple[list[float], list[float], list[float]]:
    """Leave-one-out on some rows of the posterior given all rows, in the order of LAWS."""
    fewer = LinearProblem(
        problem.y[some], problem.B[some], problem.R[some], None, problem.names, problem.units
    )
    part = {
        name: dataclasses.replace(
            d,
            posterior=dataclasses.replace(d.posterior, problem=fewer),
            theta=d.theta[:, :draws],
            stats={},
        )
        for name, d in found.items()
    }
    ranked = {r.name: r for r in compare_laws(part)}
    rows = [ranked[name] for name in found]
    return [r.elpd for r in rows], [r.behind for r in rows], [r.standard_error for r in rows]
