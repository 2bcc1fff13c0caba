"""A bias that drifts beside a moving target: every method against the exact filter and smoother.

Figures `drift_methods` and `drift_trace` are drawn from it.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from experiments.drift_scene import LAWS, joint_dynamics, joint_model, settings
from probreg.diagnostics import normal_interval
from probreg.estimators import Recursive
from probreg.estimators.recursive import after_each_time
from probreg.motion.trajectory import Trajectory
from probreg.noise import Gaussian, Huber, Hyperbolic, NoiseLaw
from probreg.posterior.path_posterior import PathPosterior
from probreg.problems import as_rows
from probreg.samplers import Nuts
from probreg.samplers.paths import GibbsPath, MetropolisPath, NutsPath, PathSampler
from probreg.samplers.scans import GaussianMemory, ParticleFilter, ScanMetropolis
from probreg.typing import FloatArray

BIAS = slice(4, 6)
ONLINE = (
    "Kalman filter",
    "RLS, forgetting 0.7",
    "RLS, forgetting 0.9",
    "Huber, process noise",
    "RALAD, process noise",
    "sequential MH",
    "particle filter",
)
WHOLE = ("RTS smoother", "Gibbs", "MH in blocks", "NUTS")


class Found(NamedTuple):
    """Mean (T, 2) and 90 % interval (T, 2, 2) of the bias."""

    mean: FloatArray
    interval: FloatArray


@dataclass(frozen=True)
class Config:
    """Truth and reports are drawn from the model; a replicate is a block of runs."""

    noise: str = "Gaussian"
    replicates: int = 20
    runs: int = 5
    seed: int = 20120306
    scans: int = 60
    forgetting: tuple[float, float] = (0.7, 0.9)
    huber: float = 1.345
    steps: int = 3000
    burn_in: int = 500
    particles: int = 500
    gibbs_draws: int = 400
    mh_chains: int = 40
    mh_draws: int = 10
    nuts_draws: int = 150
    nuts_warmup: int = 120

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return {**dataclasses.asdict(self), "law": repr(LAWS[self.noise]), **settings(self.scans)}


PROFILES = {"quick": Config(replicates=2, runs=1, nuts_draws=60), "paper": Config()}
GRID = {"noise": tuple(LAWS)}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: squared errors and coverage of every method, and one example."""
    law, base = LAWS[config.noise], joint_model(config.scans)
    square, held, seconds, example = [], [], [], []
    truth: FloatArray = np.empty(0)
    for run in range(config.runs):
        path, model = base.simulate(law, rng)
        bias = path[:, BIAS]
        found, spent = [], []
        for method in methods(config, model, law).values():
            begin = time.perf_counter()
            found.append(method(rng))
            spent.append(time.perf_counter() - begin)
        square.append([((f.mean - bias) ** 2).sum(axis=1) for f in found])
        inside = [(f.interval[..., 0] <= bias) & (bias <= f.interval[..., 1]) for f in found]
        held.append([own.mean(axis=1) for own in inside])
        seconds.append(spent)
        if run == 0:
            truth = bias
            example = [np.concatenate([f.mean[..., None], f.interval], axis=-1) for f in found]
    dims = ("run", "estimator", "time")
    return xr.Dataset(
        {
            "square": (dims, np.array(square)),
            "held": (dims, np.array(held)),
            "seconds": (dims[:2], np.array(seconds)),
            "example": (("estimator", "time", "axis", "bound"), np.array(example)),
            "past_only": ("estimator", [name in ONLINE for name in (*ONLINE, *WHOLE)]),
            "example_truth": (("time", "axis"), truth),
        },
        {
            "estimator": [*ONLINE, *WHOLE],
            "time": base.time,
            "axis": ["x", "y"],
            "bound": ["mean", "low", "high"],
        },
    )


Method = Callable[[np.random.Generator], Found]


def methods(config: Config, model: Trajectory, law: NoiseLaw) -> dict[str, Method]:
    """Every method by name: those that see the past only, then those that see all scans."""
    filtered, smoothed = model.filtered, model.smooth()
    known, still = joint_dynamics(config.scans), joint_dynamics(config.scans, drifting=False)
    huber = Recursive(Huber(config.huber, componentwise=True), covariance_path=True, dynamics=known)
    ralad = Recursive(Hyperbolic(), covariance_path=True, dynamics=known)
    # what forgets does not know that the bias drifts
    short, long = (
        Recursive(Gaussian(), covariance_path=True, dynamics=still, forgetting=forget)
        for forget in config.forgetting
    )
    box = np.array([[-4e4, 4e4]] * 2 + [[-1e3, 1e3]] * 2 + [[-2e3, 2e3]] * 2)
    tracker = ScanMetropolis(GaussianMemory(), law, config.steps, config.burn_in, box=box)
    particles = ParticleFilter(law, config.particles)
    nuts = NutsPath(Nuts(warmup=config.nuts_warmup))
    found: list[Method] = [
        lambda rng: _normal(filtered.mean, filtered.covariance),
        lambda rng: _recursive(short, model),
        lambda rng: _recursive(long, model),
        lambda rng: _recursive(huber, model),
        lambda rng: _recursive(ralad, model),
        lambda rng: _tracked(tracker, model, rng),
        lambda rng: _tracked(particles, model, rng),
        lambda rng: _normal(smoothed.mean, smoothed.covariance),
        _path(GibbsPath(), model, law, config.gibbs_draws, 1),
        _path(MetropolisPath(), model, law, config.mh_draws, config.mh_chains),
        _path(nuts, model, law, config.nuts_draws, 1),
    ]
    return dict(zip([*ONLINE, *WHOLE], found, strict=True))


def _normal(mean: FloatArray, covariance: FloatArray) -> Found:
    return Found(mean[:, BIAS], normal_interval(mean, covariance, 0.9)[:, BIAS])


def _recursive(estimator: Recursive, model: Trajectory) -> Found:
    problem = as_rows(model)
    return _normal(*after_each_time(estimator.estimate(problem, model.prior), problem))


def _tracked(
    tracker: ScanMetropolis | ParticleFilter, model: Trajectory, rng: np.random.Generator
) -> Found:
    track = tracker.track(model, rng)
    return Found(track.mean[:, BIAS], track.interval(0.9)[:, BIAS])


def _path(
    sampler: PathSampler, model: Trajectory, law: NoiseLaw, draws: int, chains: int
) -> Method:
    def sample(rng: np.random.Generator) -> Found:
        found = sampler.sample(PathPosterior(model, law), draws, chains, rng)
        return Found(found.mean[:, BIAS], found.interval(0.9)[:, BIAS])

    return sample
