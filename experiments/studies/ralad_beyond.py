"""Beyond the RALAD paper: where B and R are evaluated, heavy-tailed laws, and the bound.

Table and figure `ralad_beyond` are drawn from it. Reading "relinearised" is the nonlinear
problem with unbiased conversion, re-linearised at the estimate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from experiments.ralad_methods import READINGS, RaladConfig, fit, labelled, readings
from experiments.ralad_methods import recursive_methods as paper_methods
from probreg import AssociatedReports, ReportProblem
from probreg.diagnostics import cramer_rao_bound
from probreg.estimators import Estimator, Irls, LeastSquares, Recursive
from probreg.noise import Contaminated, Hyperbolic, StudentT
from probreg.problems.linear import LinearProblem, Problem
from probreg.scenarios.ralad import RaladTruth, simulate


@dataclass(frozen=True)
class Config(RaladConfig):
    """Settings of the RALAD scene and of the laws beyond the paper."""

    nu: float = 3.0
    contamination_rate: float = 0.3
    contamination_scale: float = 30.0


PROFILES = {"quick": Config(replicates=8), "paper": Config()}
GRID = {"case": (0, 1, 2)}
ORACLE = "least squares, clean rows only"


def methods(config: Config) -> dict[str, Estimator]:
    """Every estimator compared, by its name in the table."""
    student = StudentT(config.nu)
    contaminated = Contaminated(config.contamination_rate, config.contamination_scale)
    return {
        **paper_methods(config),
        "batch LAD": Irls(Hyperbolic(config.mu)),
        "Student-t, recursive": Recursive(student, config.omega),
        "Student-t, batch": Irls(student),
        "contaminated, recursive": Recursive(contaminated, config.omega),
        "contaminated, batch": Irls(contaminated),
    }


RELINEARISED = ("RALAD", "Student-t, batch", "contaminated, batch")


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """Simulate one run; apply every method under every reading, and on the clean rows only."""
    data, truth = simulate(config.scene, rng)
    problems: dict[str, Problem] = {**readings(data, truth, config.smoothing_window)}
    problems["relinearised"] = ReportProblem(data)
    found = methods(config)
    shape = (len(problems), len(found) + 1, truth.bias.size)
    theta, sd, restless = np.full(shape, np.nan), np.full(shape, np.nan), np.zeros(shape[:2], int)
    for r, (reading, problem) in enumerate(problems.items()):
        for k, (name, method) in enumerate(found.items()):
            if problem.linear or name in RELINEARISED:
                estimate, sd[r, k] = fit(method, problem, rng)
                theta[r, k], restless[r, k] = estimate.theta, not estimate.converged
        oracle, sd[r, -1] = fit(LeastSquares(), _clean(reading, data, truth, problems), rng)
        theta[r, -1] = oracle.theta
    true = problems["true"]
    dims = ("reading", "estimator", "parameter")
    return labelled(
        {
            "theta": (dims, theta),
            "claimed_sd": (dims, sd),
            "not_converged": (dims[:2], restless),
            "bound_sd": (("parameter",), np.sqrt(np.diag(cramer_rao_bound(true, truth.bias)))),
            "clean_share": ((), truth.clean.mean()),
        },
        reading=[*READINGS, "relinearised"],
        estimator=[*found, ORACLE],
        parameter=list(true.names),
        truth=("parameter", truth.bias),
    )


def _clean(
    reading: str, data: AssociatedReports, truth: RaladTruth, problems: dict[str, Problem]
) -> Problem:
    """The rows with the right pairing and nominal noise: what an oracle would keep."""
    keep = truth.clean
    problem = problems[reading]
    if isinstance(problem, LinearProblem):
        return LinearProblem(
            problem.y[keep], problem.B[keep], problem.R[keep], None, problem.names, problem.units
        )
    return ReportProblem(AssociatedReports(data.sensors, tuple(v[keep] for v in data.values)))
