"""Metropolis-Hastings paper (Zhou et al. 2012): its protocol, and correct sequential inference.

Figures `mh_fig1` to `mh_fig8` and table `mh_table` are drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from probreg import GaussianPrior, LinearProblem, ReportProblem
from probreg.diagnostics import normal_interval
from probreg.motion.dynamics import Constant, RandomWalk
from probreg.motion.trajectory import Trajectory
from probreg.problems import as_trajectory
from probreg.samplers.scans import AccumulatedMemory, Flat, GaussianMemory, ScanMetropolis
from probreg.scenarios.uturn import UturnScene, simulate
from probreg.typing import FloatArray

FORMS = ("reference", "pair")
METHODS = (
    "uncorrected",
    "paper's protocol",
    "flat prior, chain mean",
    "sequential MH",
    "Kalman filter",
    "RTS smoother",
)


@dataclass(frozen=True)
class Config:
    """The paper's numbers; a replicate is a block of runs."""

    drifting: bool = True
    replicates: int = 20
    runs: int = 20
    seed: int = 20120302
    gamma: float = 10.0
    paper_steps: int = 50
    paper_step_m: float = 20.0
    paper_start_m: float = -1000.0
    share_global: float = 0.1
    steps: int = 1000
    burn_in: int = 200
    box_m: float = 2000.0
    constant_prior_sd_m: float = 300.0

    def scene(self, form: Any) -> UturnScene:
        """The scene in one of its forms."""
        return UturnScene(form, self.drifting)

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        scene = dataclasses.asdict(self.scene("reference"))
        return {**dataclasses.asdict(self), "scene": scene}


PROFILES = {"quick": Config(replicates=2, runs=10), "paper": Config()}
GRID = {"drifting": (True, False)}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs of both forms under every method, with one example."""
    T = config.scene("reference").scans
    shape = (config.runs, len(FORMS), len(METHODS))
    bias_square, position_square = np.empty((*shape, T)), np.empty((*shape, T))
    held = np.full((*shape, T), np.nan)
    examples = []
    for run in range(config.runs):
        seed = int(rng.integers(2**62))
        for f, form in enumerate(FORMS):
            data, truth = simulate(config.scene(form), np.random.default_rng(seed))
            model = trajectory(config, ReportProblem(data))
            found = _follow(config, model, np.random.default_rng(seed + 1))
            # a fresh target of the same sensor: scoring the one that gave the bias is circular
            spread = np.sqrt(config.scene(form).noise_variance_m2)
            fresh = spread * np.random.default_rng(seed + 2).standard_normal((T, 2))
            for m, (mean, interval) in enumerate(found):
                gap = truth.bias - mean
                bias_square[run, f, m] = (gap**2).sum(axis=1)
                position_square[run, f, m] = ((gap + fresh) ** 2).sum(axis=1)
                if interval is not None:
                    inside = (interval[..., 0] <= truth.bias) & (truth.bias <= interval[..., 1])
                    held[run, f, m] = inside.mean(axis=1)
            if run == 0:
                estimates = np.array([mean for mean, _ in found])
                examples.append((estimates, truth.bias, data.values[0]))
    dims = ("run", "form", "estimator")
    estimate, bias, reports = (np.array(part) for part in zip(*examples, strict=True))
    return xr.Dataset(
        {
            "bias_square": ((*dims, "time"), bias_square),
            "position_square": ((*dims, "time"), position_square),
            "held": ((*dims, "time"), held),
            "example_estimate": (("form", "estimator", "time", "axis"), estimate),
            "example_bias": (("form", "time", "axis"), bias),
            "example_reports": (("form", "time", "axis"), reports),
            "positions": (("time", "axis"), truth.positions),
        },
        {
            "form": list(FORMS),
            "estimator": list(METHODS),
            "time": np.arange(1.0, T + 1.0),
            "axis": ["x", "y"],
        },
    )


def trajectory(config: Config, problem: ReportProblem) -> Trajectory:
    """The sensor's own two biases; those of what it is compared with are known to be zero."""
    linear = problem.linearise(np.zeros(4))
    own = LinearProblem(
        linear.y, linear.B[:, :, :2], linear.R, linear.time, linear.names[:2], linear.units[:2]
    )
    if config.drifting:
        # zero before the first scan: one step of drift at it
        rate = config.scene("reference").drift_variance_m2 * np.ones(2)
        return as_trajectory(own, RandomWalk(rate), GaussianPrior.from_sd(np.sqrt(rate)))
    prior = GaussianPrior.from_sd(np.full(2, config.constant_prior_sd_m))
    return as_trajectory(own, Constant(), prior)


def _follow(
    config: Config, model: Trajectory, rng: np.random.Generator
) -> list[tuple[FloatArray, FloatArray | None]]:
    """Mean (T, 2) and 90 % interval (T, 2, 2) of every method, in the order of METHODS."""
    paper = ScanMetropolis(
        Flat(),
        steps=config.paper_steps,
        burn_in=0,
        step=config.paper_step_m,
        share_global=config.share_global,
        gamma=config.gamma,
        box=config.box_m,
        start=np.full(2, config.paper_start_m),
        estimate="last",
    )
    flat, sequential = (
        ScanMetropolis(
            target,
            steps=config.steps,
            burn_in=config.burn_in,
            share_global=config.share_global,
            box=config.box_m,
        )
        for target in (Flat(), GaussianMemory() if config.drifting else AccumulatedMemory())
    )
    tracks = [tracker.track(model, rng) for tracker in (paper, flat, sequential)]
    filtered, smoothed = model.filtered, model.smooth()
    exact = [(filtered.mean, filtered.covariance), (smoothed.mean, smoothed.covariance)]
    return [
        (np.zeros_like(filtered.mean), None),
        *((track.mean, track.interval(0.9)) for track in tracks),
        *((mean, normal_interval(mean, covariance, 0.9)) for mean, covariance in exact),
    ]
