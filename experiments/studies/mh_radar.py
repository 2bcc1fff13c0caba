"""Drifting (or constant) radar biases, outliers, exchanged reports: every method on the same data.

Figure `mh_radar` is drawn from it.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from probreg import GaussianPrior, LinearProblem, ReportProblem
from probreg.diagnostics import normal_interval
from probreg.estimators import Irls, Recursive
from probreg.estimators.recursive import after_each_time
from probreg.motion.dynamics import Constant, Dynamics, RandomWalk
from probreg.motion.trajectory import Trajectory
from probreg.noise import Contaminated, Gaussian, Huber, Hyperbolic, NoiseLaw, StudentT
from probreg.posterior.path_posterior import PathPosterior
from probreg.problems import as_trajectory
from probreg.samplers import Nuts
from probreg.samplers.paths import GibbsPath, NutsPath, PathSampler
from probreg.samplers.scans import AllScans, GaussianMemory, ScanMetropolis, ScanTarget
from probreg.scenarios.ralad import CASES, RaladScene, simulate
from probreg.typing import FloatArray

STUDENT = StudentT(2.0)
CONTAMINATED = Contaminated(0.3, 30.0)


class Found(NamedTuple):
    """What a method says at each scan: mean (T, 6) and 90 % interval (T, 6, 2)."""

    mean: FloatArray
    interval: FloatArray


@dataclass(frozen=True)
class Config:
    """RALAD case 1, its flight seen in fewer scans (a second apart); a replicate is one run."""

    drifting: bool = True
    replicates: int = 40
    seed: int = 20120304
    scans: int = 80
    drift_range_m: float = 2.0
    drift_angle_deg: float = 0.05
    settle_scans: int = 10
    omega: float = 1e6
    forgetting: float = 0.9
    steps: int = 2000
    burn_in: int = 500
    all_scans_steps: int = 500
    all_scans_burn_in: int = 100
    box: tuple[float, float] = (400.0, 0.06)
    gibbs_draws: int = 400
    nuts_draws: int = 100
    nuts_warmup: int = 100

    @property
    def scene(self) -> RaladScene:
        """The scene, with drift or without."""
        moved = {
            "drift_range_m": self.drift_range_m,
            "drift_angle_deg": self.drift_angle_deg,
        }
        changes: dict[str, Any] = moved if self.drifting else {}
        return dataclasses.replace(CASES[1].in_scans(self.scans), **changes)

    @property
    def dynamics(self) -> Dynamics:
        """What every method is told of the drift."""
        return RandomWalk(self.scene.drift_rate) if self.drifting else Constant()

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        laws = {"Student-t": repr(STUDENT), "contaminated": repr(CONTAMINATED)}
        return {**dataclasses.asdict(self), "scene": dataclasses.asdict(self.scene), "laws": laws}


QUICK = Config(
    replicates=2, scans=40, steps=800, burn_in=200, all_scans_steps=200, all_scans_burn_in=50,
    gibbs_draws=100, nuts_draws=40, nuts_warmup=60,
)  # fmt: skip
PROFILES = {"quick": QUICK, "paper": Config()}
GRID = {"drifting": (True, False)}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """One run: squared errors, coverage and seconds of every method."""
    data, truth = simulate(config.scene, rng)
    problem = ReportProblem(data)
    # one linear form for all: at a robust fit of constant biases
    linear = problem.linearise(Irls(Hyperbolic()).estimate(problem).theta)
    prior = GaussianPrior.from_sd(problem.prior_sd)
    model = as_trajectory(linear, config.dynamics, prior)
    late = slice(config.settle_scans, None)
    square, held, width, seconds = [], [], [], []
    for method in methods(config, linear, model, prior).values():
        begin = time.perf_counter()
        found = method(rng)
        seconds.append(time.perf_counter() - begin)
        square.append(((found.mean - truth.path)[late] ** 2).mean(axis=0))
        low, high = np.moveaxis(found.interval[late], -1, 0)
        held.append(((low <= truth.path[late]) & (truth.path[late] <= high)).mean(axis=0))
        width.append((high - low).mean(axis=0))
    dims = ("estimator", "parameter")
    return xr.Dataset(
        {
            "square": (dims, np.array(square)),
            "held": (dims, np.array(held)),
            "width": (dims, np.array(width)),
            "seconds": ("estimator", np.array(seconds)),
        },
        {
            "estimator": list(methods(config, linear, model, prior)),
            "parameter": list(problem.names),
        },
    )


Method = Callable[[np.random.Generator], Found]


def methods(
    config: Config, linear: LinearProblem, model: Trajectory, prior: GaussianPrior
) -> dict[str, Method]:
    """Every method by its name in the figure; all but those that forget know the drift."""

    def recursive(noise: NoiseLaw, forgetting: float = 1.0) -> Method:
        dynamics = Constant() if forgetting < 1.0 else config.dynamics
        estimator = Recursive(noise, covariance_path=True, dynamics=dynamics, forgetting=forgetting)
        return lambda rng: _recursive(estimator, linear, prior)

    def tracker(noise: NoiseLaw, gamma: float) -> Method:
        return lambda rng: _tracked(config, model, noise, gamma, rng)

    def path(sampler: PathSampler, noise: NoiseLaw, draws: int) -> Method:
        return lambda rng: _path(sampler, model, noise, draws, rng)

    gibbs, nuts = GibbsPath(), NutsPath(Nuts(warmup=config.nuts_warmup))
    return {
        "RLS": recursive(Gaussian()),
        "RLS, forgetting": recursive(Gaussian(), config.forgetting),
        "Huber": recursive(Huber(1.345, componentwise=True)),
        "Huber, forgetting": recursive(Huber(1.345, componentwise=True), config.forgetting),
        "RALAD": recursive(Hyperbolic()),
        "RALAD, forgetting": recursive(Hyperbolic(), config.forgetting),
        "MH tracker, Student-t": tracker(STUDENT, 1.0),
        "MH tracker, Student-t, gamma 10": tracker(STUDENT, 10.0),
        "MH tracker, contaminated": tracker(CONTAMINATED, 1.0),
        "MH tracker, contaminated, gamma 10": tracker(CONTAMINATED, 10.0),
        "Gibbs, Student-t": path(gibbs, STUDENT, config.gibbs_draws),
        "Gibbs, contaminated": path(gibbs, CONTAMINATED, config.gibbs_draws),
        "NUTS, Student-t": path(nuts, STUDENT, config.nuts_draws),
    }


def _recursive(estimator: Recursive, linear: LinearProblem, prior: GaussianPrior) -> Found:
    estimate = estimator.estimate(linear, prior)
    mean, covariance = after_each_time(estimate, linear)
    return Found(mean, normal_interval(mean, covariance, 0.9))


def _tracked(
    config: Config, model: Trajectory, noise: NoiseLaw, gamma: float, rng: np.random.Generator
) -> Found:
    reach = np.tile([config.box[0], config.box[1], config.box[1]], 2)
    target: ScanTarget = GaussianMemory()
    steps, burn_in = config.steps, config.burn_in
    if not config.drifting:  # moments refitted scan by scan would lose a constant bias
        target, steps, burn_in = AllScans(), config.all_scans_steps, config.all_scans_burn_in
    box = np.stack([-reach, reach], axis=1)
    tracker = ScanMetropolis(target, noise, steps, burn_in, gamma=gamma, box=box)
    track = tracker.track(model, rng)
    return Found(track.mean, track.interval(0.9))


def _path(
    sampler: PathSampler,
    model: Trajectory,
    noise: NoiseLaw,
    num_draws: int,
    rng: np.random.Generator,
) -> Found:
    draws = sampler.sample(PathPosterior(model, noise), num_draws, 1, rng)
    return Found(draws.mean, draws.interval(0.9))
