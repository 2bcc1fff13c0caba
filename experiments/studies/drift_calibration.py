"""Simulation-based calibration of the samplers of whole paths: target and drifting bias together.

Figure `drift_calibration` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from experiments.drift_scene import LAWS, joint_model, settings
from probreg.posterior.path_posterior import PathPosterior
from probreg.samplers import Nuts
from probreg.samplers.paths import (
    GibbsPath,
    MetropolisPath,
    NutsPath,
    PathDraws,
    PathSampler,
    StepScale,
)
from probreg.typing import FloatArray, IntArray

SCANS = 20
SEEN = (0, 9, 19)
STATES = (0, 2, 4, 5)  # position, velocity, both offsets
UNKNOWN = StepScale(("sensor.x", "sensor.y"), median=1.0, spread=0.5)


@dataclass(frozen=True)
class Config:
    """The truth is ranked among `keep` draws; NUTS in every fifth run."""

    replicates: int = 50
    runs: int = 10
    seed: int = 20120307
    keep: int = 49
    thin: int = 4
    nuts_every: int = 5
    nuts_warmup: int = 100

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        own = {"seen": SEEN, "states": STATES, "unknown": repr(UNKNOWN)}
        law = {"law": repr(LAWS["Student-t"])}
        return {**dataclasses.asdict(self), **law, **own, **settings(SCANS)}


PROFILES = {"quick": Config(replicates=2, runs=5), "paper": Config()}
GRID: dict[str, tuple[Any, ...]] = {}
ABSENT = -1


def samplers(config: Config) -> dict[str, tuple[PathSampler, int, int]]:
    """Each with its draws and chains: many chains of one draw, or one thinned chain."""
    one = config.keep * config.thin
    return {
        "Gibbs": (GibbsPath(), one, 1),
        "Gibbs, process noise unknown": (GibbsPath(unknown=(UNKNOWN,)), one, 1),
        "MH in blocks": (MetropolisPath(), 1, config.keep),
        "NUTS": (NutsPath(Nuts(warmup=config.nuts_warmup)), one, 1),
    }


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """A block of runs: ranks of states at three scans, of the rows' density, of the factor."""
    law, base = LAWS["Student-t"], joint_model(SCANS)
    names = [f"{base.names[k]}[{t}]" for t in SEEN for k in STATES]
    names += ["log_likelihood", "process noise"]
    methods = samplers(config)
    ranks = np.full((config.runs, len(methods), len(names)), ABSENT)
    for run in range(config.runs):
        factor = float(np.exp(UNKNOWN.spread * rng.standard_normal()))
        spots = np.where(UNKNOWN.spots(base) > 0.0, factor, 1.0)
        drifts = dataclasses.replace(base, Q=base.Q * np.outer(spots, spots))
        known, unknown = base.simulate(law, rng), drifts.simulate(law, rng)
        for m, (name, (sampler, draws, chains)) in enumerate(methods.items()):
            if name == "NUTS" and run % config.nuts_every:
                continue
            path, model = unknown if "unknown" in name else known
            posterior = PathPosterior(dataclasses.replace(model, Q=base.Q), law)
            found = sampler.sample(posterior, draws, chains, rng)
            ranks[run, m, :-1] = _ranks(found, path, config.keep, rng)
            if "unknown" in name:
                assert found.step_scale is not None
                scales = found.step_scale.ravel()[:: config.thin]
                ranks[run, m, -1] = int((scales < factor).sum())
    return xr.Dataset(
        {"ranks": (("run", "sampler", "quantity"), ranks)},
        {"sampler": list(methods), "quantity": names},
    )


def _ranks(draws: PathDraws, truth: FloatArray, keep: int, rng: np.random.Generator) -> IntArray:
    paths = np.swapaxes(draws.path, 0, 1).reshape(-1, *truth.shape)
    kept = paths[:: len(paths) // keep][:keep]
    at = np.ix_(SEEN, STATES)
    values = np.array([path[at].ravel() for path in kept])
    density = draws.posterior.log_likelihood(kept).sum(axis=-1)
    own = draws.posterior.log_likelihood(truth).sum()
    return np.append((values < truth[at].ravel()).sum(axis=0), (density < own).sum())
