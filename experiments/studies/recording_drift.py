"""A bias that moves while asynchronous radars watch: every method on the same recording.

The paper's Metropolis-Hastings tracker and recursive estimators follow what each slice of time
says of the biases, targets' paths integrated out; beside them the exact filter and smoother of the
same slices, samplers of whole paths, the watch, and the posteriors of the whole recording. Figure
`recording_drift` is drawn from it.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from probreg.diagnostics import normal_interval
from probreg.estimators import Recursive
from probreg.estimators.recursive import after_each_time
from probreg.motion.dynamics import Constant, RandomWalk
from probreg.motion.trajectory import Trajectory
from probreg.noise import Gaussian, Huber, Hyperbolic
from probreg.posterior.path_posterior import PathPosterior
from probreg.problems import as_rows
from probreg.recordings import Recording, Setup
from probreg.registration import register
from probreg.samplers import Nuts
from probreg.samplers.paths import GibbsPath, NutsPath, PathSampler
from probreg.samplers.scans import Flat, GaussianMemory, ScanMetropolis
from probreg.scenarios.drifting import Drift, DriftingScene, Ramp, Step, Walk, simulate
from probreg.scenarios.traffic import TrafficScene
from probreg.typing import FloatArray
from probreg.watch import WatchSettings, begin
from probreg.watch.slices import SlicedRecording, sliced

MOVING = "radar1.azimuth"
REPORTS_A_SECOND = 23.5  # of 40 aircraft and three radars: more than are seen
NEEDS_NO_SLICES = ("constant bias", "drift, spread unknown")
ONLINE = (
    "watch, spread unknown",
    "exact filter",
    "MH",
    "MH, gamma 10",
    "MH, flat prior a slice",
    "MH, paper's small steps",
    "RLS, forgetting",
    "Huber",
    "RALAD",
)
WHOLE = (*NEEDS_NO_SLICES, "exact smoother", "Gibbs", "NUTS")


class Found(NamedTuple):
    """Mean (T,) and 90 % interval (T, 2) of the moving bias, radians."""

    mean: FloatArray
    interval: FloatArray


@dataclass(frozen=True)
class Config:
    """A replicate is a recording.

    The walk is in degrees a root minute: that of the truth where it walks, and that which methods
    on slices assume of every azimuth whatever the truth does. Assumed of ranges: metres a root
    minute.
    """

    truth: str = "walk"
    replicates: int = 40
    seed: int = 20120308
    minutes: float = 30.0
    first_s: float = 180.0
    aircraft: int = 40
    wrong_share: float = 0.2
    outlier_share: float = 0.05
    walk_deg: float = 0.02
    range_walk_m: float = 0.1
    step_deg: float = 0.1
    ramp_deg_per_hour: float = 0.2
    forgetting: float = 0.9
    huber: float = 1.345
    steps: int = 5000
    burn_in: int = 500
    small_step_deg: float = 0.002
    small_step_m: float = 1.0
    small_steps: int = 50
    draws: int = 500
    nuts_draws: int = 150
    nuts_warmup: int = 120

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        scene, settings = scene_of(self).traffic, WatchSettings()
        shown = {key: getattr(scene, key) for key in ("reports", "scan_s", "outlier_factor")}
        return {**dataclasses.asdict(self), **shown, "watch": dataclasses.asdict(settings)}


PROFILES = {
    "quick": Config(replicates=2, minutes=10.0, steps=1000, burn_in=200, nuts_draws=40),
    "paper": Config(),
}
GRID = {"truth": ("walk", "step", "ramp", "none")}


def scene_of(config: Config) -> DriftingScene:
    """The traffic, and how its first radar's azimuth bias moves."""
    half = 30.0 * config.minutes
    kinds: dict[str, Drift] = {
        "walk": Walk(np.deg2rad(config.walk_deg)),
        "step": Step(half, np.deg2rad(config.step_deg)),
        "ramp": Ramp(half, np.deg2rad(config.ramp_deg_per_hour)),
    }
    traffic = TrafficScene(
        reports=round(60.0 * config.minutes * REPORTS_A_SECOND * config.aircraft / 40.0),
        aircraft=config.aircraft,
        wrong_share=config.wrong_share,
        outlier_share=config.outlier_share,
    )
    moving = {MOVING: kinds[config.truth]} if config.truth in kinds else {}
    return DriftingScene(traffic, moving)


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """One recording: means and intervals of every method over time, beside the truth, degrees."""
    whole, setup, truth = simulate(scene_of(config), rng)
    settings = WatchSettings()
    start = float(whole.time[0])
    # of one length, so that every recording has the same slices
    recording = whole.during(-np.inf, start + 60.0 * config.minutes)
    first = recording.during(-np.inf, start + config.first_s)
    state = begin(first, setup, settings, rng)
    pace = {"rad": np.deg2rad(config.walk_deg), "m": config.range_walk_m}
    walk = np.array([pace[unit] for unit in state.units]) / np.sqrt(60.0)
    begun = time.perf_counter()
    seen = sliced(state, recording, walk)
    shared = time.perf_counter() - begun
    at, found, seconds = common_times(seen), [], []
    for name, method in methods(config, seen, walk, (recording, setup)).items():
        begun = time.perf_counter()
        found.append(method(rng, at))
        # all that goes by slices needs the watch first
        own = 0.0 if name in NEEDS_NO_SLICES else shared
        seconds.append(own + time.perf_counter() - begun)
    bands = [np.column_stack([f.mean, f.interval]) for f in found]
    names = [*ONLINE, *WHOLE]
    return xr.Dataset(
        {
            "bias": (("estimator", "time", "bound"), np.rad2deg(bands)),
            "truth": ("time", np.rad2deg(truth.bias(MOVING, at))),
            "seconds": ("estimator", np.array(seconds)),
            "past_only": ("estimator", [name in ONLINE for name in names]),
        },
        {"estimator": names, "time": np.round(at - start, 6), "bound": ["mean", "low", "high"]},
        {"p_constant": float(seen.results[-1].constant[seen.model.names.index(MOVING)])},
    )


def common_times(seen: SlicedRecording) -> FloatArray:
    """Middles of the slices that have closed and of which the watch spoke while they were new."""
    new = [result.time - 0.5 * seen.state.settings.slice_s for result in seen.results]
    assert seen.model.time is not None
    return seen.model.time[seen.model.time >= new[0] - 1e-6]


Method = Callable[[np.random.Generator, FloatArray], Found]


def methods(
    config: Config, seen: SlicedRecording, walk: FloatArray, given: tuple[Recording, Setup]
) -> dict[str, Method]:
    """Every method by name: those that see the past only, then those that see all."""
    model = seen.model
    chain = ScanMetropolis(GaussianMemory(), steps=config.steps, burn_in=config.burn_in)
    flat = dataclasses.replace(chain, target=Flat())
    step = {"rad": np.deg2rad(config.small_step_deg), "m": config.small_step_m}
    paper = ScanMetropolis(
        Flat(),
        steps=config.small_steps,
        burn_in=0,
        step=np.array([step[unit] for unit in model.units]),
        gamma=10.0,
        estimate="last",
    )
    law, drifting, still = Huber(config.huber), RandomWalk(walk**2), Constant()
    filtered, smoothed = model.filtered, model.smooth()
    nuts = NutsPath(Nuts(warmup=config.nuts_warmup))
    found: list[Method] = [
        lambda rng, at: _watched(seen, at),
        lambda rng, at: _normal(model, (filtered.mean, filtered.covariance), at),
        *(_tracked(one, model) for one in (chain, dataclasses.replace(chain, gamma=10.0))),
        *(_tracked(one, model) for one in (flat, paper)),
        _recursive(Recursive(Gaussian(), dynamics=still, forgetting=config.forgetting), model),
        _recursive(Recursive(law, dynamics=drifting), model),
        _recursive(Recursive(Hyperbolic(), dynamics=drifting), model),
        lambda rng, at: _registered(*given, rng, at),
        lambda rng, at: _registered(given[0], with_drift(given[1]), rng, at),
        lambda rng, at: _normal(model, (smoothed.mean, smoothed.covariance), at),
        _path(GibbsPath(), model, config.draws),
        _path(nuts, model, config.nuts_draws),
    ]
    return dict(zip([*ONLINE, *WHOLE], found, strict=True))


def with_drift(setup: Setup) -> Setup:
    """Every azimuth may walk."""
    moving = {f"{s.name}.azimuth": "walk" for s in setup.sensors}
    return dataclasses.replace(setup, drift=moving)


def _at(model: Trajectory, mean: FloatArray, interval: FloatArray, at: FloatArray) -> Found:
    """The moving bias at some of the scans."""
    assert model.time is not None
    rows, own = np.isin(model.time, at), model.names.index(MOVING)
    return Found(mean[rows, own], interval[rows, own])


def _normal(model: Trajectory, moments: tuple[FloatArray, FloatArray], at: FloatArray) -> Found:
    return _at(model, moments[0], normal_interval(*moments, 0.9), at)


def _watched(seen: SlicedRecording, at: FloatArray) -> Found:
    """What the watch said of each slice at its end."""
    own = seen.model.names.index(MOVING)
    new = np.array([result.time for result in seen.results]) - 0.5 * seen.state.settings.slice_s
    mean, sd = (np.array([getattr(r, key)[own] for r in seen.results]) for key in ("mean", "sd"))
    rows = np.array([int(np.argmin(np.abs(new - t))) for t in at])
    interval = normal_interval(mean[:, None], np.square(sd)[:, None, None], 0.9)[:, 0]
    return Found(mean[rows], interval[rows])


def _tracked(tracker: ScanMetropolis, model: Trajectory) -> Method:
    def follow(rng: np.random.Generator, at: FloatArray) -> Found:
        track = tracker.track(model, rng)
        return _at(model, track.mean, track.interval(0.9), at)

    return follow


def _recursive(estimator: Recursive, model: Trajectory) -> Method:
    def run(rng: np.random.Generator, at: FloatArray) -> Found:
        problem = as_rows(model)
        known = dataclasses.replace(estimator, covariance_path=True)
        moments = after_each_time(known.estimate(problem, model.prior), problem)
        return _normal(model, moments, at)

    return run


def _path(sampler: PathSampler, model: Trajectory, draws: int) -> Method:
    def sample(rng: np.random.Generator, at: FloatArray) -> Found:
        found = sampler.sample(PathPosterior(model, Gaussian()), draws, 1, rng)
        return _at(model, found.mean, found.interval(0.9), at)

    return sample


def _registered(
    recording: Recording, setup: Setup, rng: np.random.Generator, at: FloatArray
) -> Found:
    """The posterior of the whole recording."""
    draws = register(recording, setup, rng=rng).path_draws(MOVING, at)
    return Found(draws.mean(axis=0), np.quantile(draws, [0.05, 0.95], axis=0).T)
