"""The MH tracker: its settings one at a time, what gamma does, chains that have not converged.

Figures `mh_sensitivity`, `mh_gamma` and `mh_lowpass` are drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.studies.mh import Config as SceneConfig
from experiments.studies.mh import trajectory
from probreg import ReportProblem, arviz_adapter
from probreg.motion.trajectory import Trajectory
from probreg.samplers.scans import Flat, GaussianMemory, ScanMetropolis, ScanTarget, Track
from probreg.scenarios.uturn import simulate
from probreg.typing import FloatArray

TARGETS: dict[str, ScanTarget] = {"flat": Flat(), "sequential": GaussianMemory()}
FACTORS: dict[str, tuple[float, ...]] = {
    "share_global": (0.0, 0.1, 0.3, 0.5, 0.9),
    "gamma": (0.5, 1.0, 2.0, 4.0, 10.0),
    "step": (3.0, 10.0, 30.0, 106.0, 300.0),
    "steps": (50.0, 100.0, 300.0, 1000.0, 3000.0),
    "warm_start": (0.0, 1.0),
}
# gamma, proposals a scan, step in metres, beta: towards a chain that has not converged
LOWPASS: dict[str, tuple[float, int, float, float]] = {
    "gamma 1, 1000 steps of 106 m": (1.0, 1000, 106.0, 0.1),
    "gamma 10, 50 steps of 20 m (the paper)": (10.0, 50, 20.0, 0.1),
    "gamma 10, 50 local steps of 5 m": (10.0, 50, 5.0, 0.0),
    "gamma 100, 20 local steps of 3 m": (100.0, 20, 3.0, 0.0),
}
ESS_SCANS = (60, 120, 179)
BOX_M = 2000.0


@dataclass(frozen=True)
class Config:
    """Form B; a replicate is a block of runs."""

    replicates: int = 10
    runs: int = 10
    seed: int = 20120305
    steps: int = 1000
    burn_share: float = 0.2
    share_global: float = 0.1
    far_start_m: float = -1000.0

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        scenes = {str(d): SceneConfig(drifting=d).resolved() for d in (True, False)}
        own = {"factors": FACTORS, "lowpass": LOWPASS, "scenes": scenes}
        return {**dataclasses.asdict(self), **own}


PROFILES = {"quick": Config(replicates=2, runs=1), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: errors, coverage, acceptance and effective draws of every setting."""
    settings = [(factor, value) for factor, values in FACTORS.items() for value in values]
    shape = (config.runs, len(TARGETS), len(settings))
    kinds = ("square", "held", "acceptance", "effective")
    found = {kind: np.empty(shape) for kind in kinds}
    low = np.empty((config.runs, len(LOWPASS) + 1, 180))
    drifting, constant = SceneConfig(drifting=True), SceneConfig(drifting=False)
    for run in range(config.runs):
        data, truth = simulate(drifting.scene("reference"), rng)
        model = trajectory(drifting, ReportProblem(data))
        for k, target in enumerate(TARGETS.values()):
            for s, (factor, value) in enumerate(settings):
                track = _tracker(config, target, factor, value).track(model, rng)
                for kind, number in zip(kinds, _judge(track, truth.bias), strict=True):
                    found[kind][run, k, s] = number
        data, truth = simulate(constant.scene("reference"), rng)
        low[run] = _lowpass(trajectory(constant, ReportProblem(data)), truth.bias, rng)
    dims = ("run", "target", "setting")
    return xr.Dataset(
        {
            **{kind: (dims, values) for kind, values in found.items()},
            "lowpass_square": (("run", "chain", "time"), low),
            "value": ("setting", [value for _, value in settings]),
        },
        {
            "target": list(TARGETS),
            "factor": ("setting", [factor for factor, _ in settings]),
            "chain": [*LOWPASS, "Kalman filter"],
            "time": np.arange(1.0, 181.0),
        },
    )


def _tracker(config: Config, target: ScanTarget, factor: str, value: float) -> ScanMetropolis:
    """The usual tracker with one setting changed."""
    settings: dict[str, Any] = {
        "steps": config.steps,
        "share_global": config.share_global,
        "box": BOX_M,
    }
    settings[factor] = type(settings.get(factor, value))(value)
    settings["burn_in"] = round(config.burn_share * settings["steps"])
    if factor == "warm_start":
        settings["warm_start"] = bool(value)
        settings["start"] = np.full(2, config.far_start_m)
    return ScanMetropolis(target, **settings)


def _judge(track: Track, truth: FloatArray) -> tuple[float, float, float, float]:
    square = float(((track.mean - truth) ** 2).sum(axis=1).mean())
    low, high = np.moveaxis(track.interval(0.9), -1, 0)
    held = float(((low <= truth) & (truth <= high)).mean())
    chains = track.draws[np.array(ESS_SCANS)]
    ess = [_effective(chain[:, k]) for chain in chains for k in range(2)]
    # kept draws are effective in the same share as all proposals would be
    effective = float(np.mean(ess)) / track.draws.shape[1]
    return square, held, float(np.mean(track.facts["acceptance"])), effective


def _effective(series: FloatArray) -> float:
    """Effective sample size; a chain that never moved has none."""
    return 0.0 if np.ptp(series) == 0.0 else arviz_adapter.ess(series[None], "mean")


def _lowpass(model: Trajectory, truth: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Squared errors (chains, T) of the last state of each scan, and of the Kalman filter."""
    means = []
    for gamma, steps, step, beta in LOWPASS.values():
        tracker = ScanMetropolis(
            Flat(), steps=steps, burn_in=0, step=step, gamma=gamma, share_global=beta, box=BOX_M,
            start=np.full(2, -1000.0), estimate="last",
        )  # fmt: skip
        means.append(tracker.track(model, rng).mean)
    means.append(model.filtered.mean)
    return ((np.array(means) - truth) ** 2).sum(axis=-1)
