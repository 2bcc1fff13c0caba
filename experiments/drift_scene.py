"""The joint state of target and bias in which paths are compared and calibrated."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from probreg import GaussianPrior
from probreg.motion.dynamics import Constant, Dynamics, NearConstantVelocity, RandomWalk, Together
from probreg.motion.target_state import Target, follow_target
from probreg.motion.trajectory import Trajectory
from probreg.noise import Gaussian, NoiseLaw, StudentT
from probreg.scenarios.uturn import UturnScene, simulate

BIAS_SD_M = 200.0
# its variance is that of the Gaussian: R (nu - 2) / nu is the scale matrix, axis by axis
LAWS: dict[str, NoiseLaw] = {
    "Gaussian": Gaussian(componentwise=True),
    "Student-t": StudentT(4.0, scale=np.sqrt(0.5), componentwise=True),
}


def target(scene: UturnScene) -> Target:
    """What is known of the target before its first report."""
    first = scene.start_m[0] + scene.speed_m_s * scene.interval_s
    return Target(np.array([first, scene.start_m[1]]), np.array([scene.speed_m_s, 0.0]))


def joint_model(scans: int) -> Trajectory:
    """Form D: one target, a drifting and a calibrated sensor; its reports are to be simulated."""
    scene = UturnScene("pair", scans=scans)
    data, _ = simulate(scene, np.random.default_rng(0))
    walk = RandomWalk(np.full(2, scene.drift_variance_m2))
    prior = GaussianPrior.from_sd(np.full(2, BIAS_SD_M))
    return follow_target(data, target(scene), {"sensor": (walk, prior)})


def joint_dynamics(scans: int, *, drifting: bool = True) -> Together:
    """How the states of `joint_model` move (or, not drifting, all but the bias)."""
    scene = UturnScene("pair", scans=scans)
    walk: Dynamics = Constant()
    if drifting:
        walk = RandomWalk(np.full(2, scene.drift_variance_m2))
    return Together(((NearConstantVelocity(target(scene).acceleration_sd), 4), (walk, 2)))


def settings(scans: int) -> dict[str, Any]:
    """Every number of the scene, for manifests."""
    scene = UturnScene("pair", scans=scans)
    known = target(scene)
    return {
        "scene": dataclasses.asdict(scene),
        "bias_sd_m": BIAS_SD_M,
        "position_sd_m": known.position_sd,
        "velocity_sd_m_s": known.velocity_sd,
        "acceleration_sd_m_s2": known.acceleration_sd,
    }
