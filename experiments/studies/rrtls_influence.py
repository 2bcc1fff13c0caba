"""Influence functions of the total-least-squares paper: one bearing moves, the estimate follows.

Figure `rrtls_influence` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.passive_methods import total_methods
from probreg import BearingProblem
from probreg.diagnostics import empirical_influence, m_influence
from probreg.estimators import Irls
from probreg.noise import Gaussian, HardReject, Igg3, NoiseLaw, StudentT
from probreg.scenarios.rrtls import RrtlsScene, simulate
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Config:
    """Shifts in standard deviations of a bearing; a replicate is one noise."""

    replicates: int = 40
    seed: int = 20150318
    point: int = 150
    reach: float = 10.0
    shifts: int = 41
    r0: float = 1.5
    r1: float = 5.0
    reject: float = 3.0
    nu: float = 4.0

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return {**dataclasses.asdict(self), "scene": dataclasses.asdict(RrtlsScene())}


PROFILES = {"quick": Config(replicates=10), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """Move the bearing of one point, whose own noise is taken away first."""
    row, sigma = config.point - 1, RrtlsScene().sensor.sigma_bearing
    shifts = sigma * np.linspace(-config.reach, config.reach, config.shifts)
    data, truth = simulate(RrtlsScene(), rng)
    noisy = BearingProblem.of(data)
    problem = noisy.shifted(row, 0, float(truth.bearing[row] - data.bearing[row]))
    clean = BearingProblem(truth.bearing, data.own_position, sigma)
    methods = total_methods(config.r0, config.r1, config.reject)
    del methods["RRTLS, robust start"]
    laws: dict[str, NoiseLaw] = {
        "RTLS": Gaussian(),
        "XRTLS": HardReject(config.reject),
        "RRTLS": Igg3(config.r0, config.r1),
        "Student-t ML": StudentT(config.nu),
    }
    methods["Student-t ML"] = Irls(StudentT(config.nu))
    empirical = [empirical_influence(m, problem, row, shifts) for m in methods.values()]
    theory = [_least_squares(problem, row, shifts)]
    theory += [_robust(clean, truth.emitter, law, row, shifts) for law in laws.values()]
    # along the line of sight, in percent of the distance from the track
    sight = truth.emitter - data.own_position[row]
    along = sight / np.linalg.norm(sight) * 100.0 / truth.emitter[1]
    dims = ("estimator", "shift")
    return xr.Dataset(
        {
            "empirical": (dims, np.array(empirical) @ along),
            "theory": (dims, np.array(theory) @ along),
        },
        {"estimator": list(methods), "shift": shifts / sigma},
    )


def _robust(
    clean: BearingProblem, emitter: FloatArray, law: NoiseLaw, row: int, shifts: FloatArray
) -> FloatArray:
    """Equations (31), (32): the lines' residuals have the size sigma times the distance."""
    distance = np.linalg.norm(emitter - clean.own_position, axis=1)
    lines = clean.lines(clean.sigma * distance.mean())
    return m_influence(lines, law, row, -distance[row] * np.sin(shifts))


def _least_squares(problem: BearingProblem, row: int, shifts: FloatArray) -> FloatArray:
    """Equation (33), with the row's coefficients H and not only its residual moved."""
    H, Z = problem.line_equations()
    inverse = np.linalg.inv(H.T @ H)
    place = inverse @ (H.T @ Z)

    def score(moved: BearingProblem) -> FloatArray:
        h, z = (part[row] for part in moved.line_equations())
        return h * (z - h @ place)

    base = score(problem)
    moved = [score(problem.shifted(row, 0, float(by))) - base for by in shifts]
    return np.array(moved) @ inverse
