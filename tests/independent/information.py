"""What reports of still targets can say about biases at best: exact Gaussian information.

Sensitivities are finite differences of the simulator's own noise-free reports. All sensors see a
target at one instant, its position is unknown, and it is eliminated.
"""

from __future__ import annotations

import numpy as np

from tests.independent.earth import displaced
from tests.independent.scene import Radar, Scene
from tests.independent.simulate import observe

MOVE_M = 5.0


def names_of(scene: Scene) -> tuple[str, ...]:
    """Biases of a scene that still targets show: all but those of time."""
    owners = (*scene.radars, *((scene.barometer,) if scene.barometer else ()))
    return tuple(f"{o.name}.{term}" for o in owners for term in o.unknown if term != "time")


def _of_radar(
    radar: Radar, places: np.ndarray, names: tuple[str, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Whitened derivatives (n, q, 3) by position and (n, q, p) by biases."""
    sigmas = np.deg2rad([0.0, radar.sigma_azimuth_deg, radar.sigma_elevation_deg])
    sigmas[0] = radar.sigma_range_m
    measured = sigmas > 0.0

    def change(ahead: np.ndarray, back: np.ndarray, step: float) -> np.ndarray:
        difference = ahead - back
        difference[:, 1] = np.angle(np.exp(1j * difference[:, 1]))
        return (difference / (2.0 * step) / np.where(measured, sigmas, 1.0))[:, measured]

    by_position = [
        change(
            *(observe(radar, displaced(places, s * axis), {}) for s in (MOVE_M, -MOVE_M)), MOVE_M
        )
        for axis in np.eye(3)
    ]
    by_bias = [
        change(*(observe(radar, places, {name: s}) for s in (1e-4, -1e-4)), 1e-4) for name in names
    ]
    return np.stack(by_position, axis=-1), np.stack(by_bias, axis=-1)


def information(scene: Scene, places: np.ndarray) -> np.ndarray:
    """Information (p, p) about the biases `names_of` in reports of targets at places (n, 3)."""
    names = names_of(scene)
    parts = [_of_radar(radar, places, names) for radar in scene.radars]
    axes = np.broadcast_to(np.eye(3), (len(places), 3, 3))
    if scene.barometer:
        columns = np.zeros((len(places), 1, len(names)))
        for k, name in enumerate(names):
            if name.startswith("barometer."):
                columns[:, 0, k] = places[:, 2] if name.endswith("_gain") else 1.0
        sigma = scene.barometer.sigma_m
        parts.append((axes[:, 2:] / sigma, columns / sigma))
    if scene.positions:
        p = scene.positions
        sigmas = np.array([p.sigma_m, p.sigma_m, p.sigma_height_m])
        parts.append((axes / sigmas[:, None], np.zeros((len(places), 3, len(names)))))
    H, G = (np.concatenate(arrays, axis=1) for arrays in zip(*parts, strict=True))
    cross = np.swapaxes(H, 1, 2) @ G
    within = np.linalg.solve(np.swapaxes(H, 1, 2) @ H, cross)
    return (np.swapaxes(G, 1, 2) @ G - np.swapaxes(cross, 1, 2) @ within).sum(axis=0)


def covariance(scene: Scene, places: np.ndarray) -> np.ndarray:
    """Posterior covariance (p, p), SI units, under the priors of the scene."""
    owners = {o.name: o for o in (*scene.radars, *((scene.barometer,) if scene.barometer else ()))}
    sd = []
    for name in names_of(scene):
        owner, term = name.split(".", 1)
        angle = term.startswith(("azimuth", "elevation"))
        sd.append(owners[owner].unknown[term] * (np.pi / 180.0 if angle else 1.0))
    scaled = np.array(sd)
    whitened = np.eye(len(sd)) + scaled[:, None] * information(scene, places) * scaled
    return scaled[:, None] * np.linalg.inv(whitened) * scaled
