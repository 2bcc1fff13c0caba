"""Steps a second of the per-scan tracker, and effective draws a second of path samplers.

Run by `make benchmark`. The tracker follows the U-turn scene with its reference target, 180
scans of 1000 proposals, beside the same loop in plain Python. The path samplers draw target and
drifting bias together, 60 scans of two sensors under Student-t noise along each axis;
effective draws are the least over the bias states. Nothing is asserted.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from experiments.drift_scene import LAWS, joint_model
from experiments.studies.mh import Config, trajectory
from probreg import ReportProblem, arviz_adapter
from probreg.motion.trajectory import Trajectory
from probreg.noise import Gaussian, NoiseLaw, StudentT
from probreg.posterior.path_posterior import PathPosterior
from probreg.samplers import Nuts
from probreg.samplers.paths import GibbsPath, MetropolisPath, NutsPath, PathSampler
from probreg.samplers.scans import Flat, GaussianMemory, ParticleMemory, ScanMetropolis, ScanTarget
from probreg.scenarios.uturn import simulate

STEPS, BIAS = 1000, (4, 5)


def scene() -> Trajectory:
    """The drifting bias of form B."""
    config = Config()
    data, _ = simulate(config.scene("reference"), np.random.default_rng(0))
    return trajectory(config, ReportProblem(data))


def best(run: Callable[[], object], times: int = 5) -> float:
    """Least seconds of several calls, after one that compiles."""
    run()
    spent = []
    for _ in range(times):
        begin = time.perf_counter()
        run()
        spent.append(time.perf_counter() - begin)
    return min(spent)


def plain_python(model: Trajectory, scans: int) -> float:
    """Seconds of the same chain, flat prior and Gaussian noise, as a loop of numpy calls."""
    rng = np.random.default_rng(0)
    v, A, _ = model.whitened
    x = np.zeros(2)
    begin = time.perf_counter()
    for t in range(scans):
        height = -0.5 * np.sum((v[t] - A[t] @ x) ** 2)
        for _ in range(STEPS):
            new = x + 106.0 * rng.standard_normal(2)
            level = -0.5 * np.sum((v[t] - A[t] @ new) ** 2)
            if np.abs(new).max() < 2000.0 and np.log(rng.random()) < level - height:
                x, height = new, level
    return time.perf_counter() - begin


def trackers() -> None:
    """Print steps a second of every target."""
    model = scene()
    settings: dict[str, tuple[ScanTarget, NoiseLaw]] = {
        "flat": (Flat(), Gaussian()),
        "Gaussian prior": (GaussianMemory(), Gaussian()),
        "Gaussian prior, Student-t": (GaussianMemory(), StudentT()),
        "400 particles": (ParticleMemory(400), Gaussian()),
    }
    plain = plain_python(model, 5) / (5 * STEPS)
    print(f"{'tracker':<28}{'180 scans (ms)':>16}{'M steps/s':>12}{'ratio to plain':>16}")
    for name, (target, law) in settings.items():
        tracker = ScanMetropolis(target, law, STEPS, 200)
        seconds = best(lambda tracker=tracker: tracker.track(model, np.random.default_rng(0)))
        rate = len(model) * STEPS / seconds
        print(f"{name:<28}{1e3 * seconds:>16.1f}{1e-6 * rate:>12.2f}{rate * plain:>16.0f}")


def samplers() -> None:
    """Print effective draws a second of every path sampler."""
    law = LAWS["Student-t"]
    _, model = joint_model(60).simulate(law, np.random.default_rng(1))
    settings: dict[str, tuple[PathSampler, int, int]] = {
        "Gibbs": (GibbsPath(), 1000, 4),
        "MH in blocks": (MetropolisPath(), 200, 64),
        "NUTS, whitened": (NutsPath(Nuts(warmup=150)), 300, 1),
    }
    print(f"\n{'paths, T = 60':<28}{'seconds':>9}{'least ESS':>11}{'ESS/s':>9}")
    for name, (sampler, draws, chains) in settings.items():
        posterior = PathPosterior(model, law)
        sampler.sample(posterior, 4, 1, np.random.default_rng(0))
        begin = time.perf_counter()
        path = sampler.sample(posterior, draws, chains, np.random.default_rng(0)).path
        spent = time.perf_counter() - begin
        states = [(t, k) for t in range(60) for k in BIAS]
        least = min(arviz_adapter.ess(path[:, :, t, k]) for t, k in states)
        print(f"{name:<28}{spent:>9.2f}{least:>11.0f}{least / spent:>9.0f}")


if __name__ == "__main__":
    with threadpool_limits(1):
        trackers()
        samplers()
