"""Two 3-D radars and forty aircraft: the scene of the RALAD paper.

Source: Guo, Wang, Ren, Hu and Mou, Control and Decision (2017), section 3.1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors import Radar3D
from probreg.sensors.reports import AssociatedReports
from probreg.typing import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class RaladScene:
    """Every number of the scene; defaults are case 1.

    Angles in degrees here, at the edge; radians inside. The paper's biases are constant; with a
    drift above zero each follows a random walk from its value at the first scan, with this
    standard deviation per root second.
    """

    pairs: int = 4
    exchanged_share: float = 0.40
    outlier_rate: float = 0.05
    outlier_factor: float = 50.0
    targets: int = 40
    scans: int = 800
    scan_interval_s: float = 0.1
    speed_m_s: float = 250.0
    start_range_m: tuple[float, float] = (19_900.0, 20_000.0)
    height_m: tuple[float, float] = (2_000.0, 3_000.0)
    aim_square_m: float = 10.0
    pair_spacing_m: float = 1_500.0
    baseline_m: float = 4_000.0
    sigma_range_m: float = 30.0
    sigma_angle_deg: float = 0.5
    bias_range_m: float = 20.0
    bias_azimuth_deg: float = -0.5
    bias_elevation_deg: float = 0.5
    drift_range_m: float = 0.0
    drift_angle_deg: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= 2 * self.pairs <= self.targets:
            raise InvalidInputError(f"{self.pairs} pairs do not fit into {self.targets} targets.")
        if not (0.0 <= self.exchanged_share <= 1.0 and 0.0 <= self.outlier_rate <= 1.0):
            raise InvalidInputError("exchanged_share and outlier_rate are shares, from 0 to 1.")

    @property
    def sensors(self) -> tuple[Radar3D, Radar3D]:
        """Radar i in the south-west, radar j in the north-east."""
        angle, b = np.deg2rad(self.sigma_angle_deg), self.baseline_m
        return (
            Radar3D((-b, -b, 0.0), self.sigma_range_m, angle, angle, name="i"),
            Radar3D((b, b, 0.0), self.sigma_range_m, angle, angle, name="j"),
        )

    @property
    def bias(self) -> FloatArray:
        """True biases, shape (6,): range, azimuth, elevation of i, then the opposite of j."""
        own = np.array(
            [
                self.bias_range_m,
                np.deg2rad(self.bias_azimuth_deg),
                np.deg2rad(self.bias_elevation_deg),
            ]
        )
        return np.concatenate([own, -own])

    @property
    def drift_rate(self) -> FloatArray:
        """Variance that each bias gains in a second, shape (6,)."""
        angle = np.deg2rad(self.drift_angle_deg)
        return np.tile([self.drift_range_m**2, angle**2, angle**2], 2)

    def in_scans(self, scans: int) -> RaladScene:
        """The same flight, watched in another number of scans."""
        interval = self.scan_interval_s * self.scans / scans
        return replace(self, scans=scans, scan_interval_s=interval)


CASES = {
    0: RaladScene(pairs=0, exchanged_share=0.0, outlier_rate=0.0),
    1: RaladScene(),
    2: RaladScene(pairs=6, exchanged_share=0.50, outlier_rate=0.10),
}


@dataclass(frozen=True, eq=False)
class RaladTruth:
    """Ground truth, hidden from the estimators.

    Attributes
    ----------
    bias : ndarray, shape (6,)
        At the first scan.
    path : ndarray, shape (scans, 6)
        At every scan.
    positions : tuple of two ndarray, shape (n, 3)
        True position of the target behind each sensor's report.
    exchanged : ndarray of bool, shape (n,)
        Rows that pair reports of different targets.
    outlier : ndarray of bool, shape (n, 6)
        Components with inflated noise.
    """

    bias: FloatArray
    path: FloatArray
    positions: tuple[FloatArray, FloatArray]
    exchanged: BoolArray
    outlier: BoolArray

    @property
    def clean(self) -> BoolArray:
        """Rows with the right pairing and nominal noise, shape (n,)."""
        return ~self.exchanged & ~self.outlier.any(axis=1)


def simulate(scene: RaladScene, rng: np.random.Generator) -> tuple[AssociatedReports, RaladTruth]:
    """Draw tracks, biased noisy reports, exchanges and outliers.

    Parameters
    ----------
    scene : RaladScene
    rng : numpy.random.Generator

    Returns
    -------
    data : AssociatedReports
        One row a target and scan, scan by scan; `tracks` numbers each sensor's own track.
    truth : RaladTruth
    """
    positions = _fly(scene, rng)  # (scans, targets, 3)
    partner = _pairing(scene, rng)  # (scans, targets): whose report sensor j contributes
    n = scene.scans * scene.targets
    own = np.tile(np.arange(scene.targets), scene.scans)
    scan = np.repeat(np.arange(scene.scans), scene.targets)
    tracks = np.stack([own, partner.ravel()], axis=1)
    path = _drift(scene, rng)
    values, outliers, seen = [], [], []
    biases = np.split(path[scan], 2, axis=1)
    for sensor, bias, track in zip(scene.sensors, biases, tracks.T, strict=True):
        truth = positions[scan, track]
        outlier = rng.random((n, 3)) < scene.outlier_rate
        stretch = np.where(outlier, scene.outlier_factor, 1.0)
        values.append(sensor.to_report(truth) + bias + stretch * sensor.sample_noise(rng, n))
        outliers.append(outlier)
        seen.append(truth)
    data = AssociatedReports(scene.sensors, tuple(values), scan * scene.scan_interval_s, tracks)
    exchanged = tracks[:, 0] != tracks[:, 1]
    return data, RaladTruth(scene.bias, path, (seen[0], seen[1]), exchanged, np.hstack(outliers))


def _fly(scene: RaladScene, rng: np.random.Generator) -> FloatArray:
    """Level flights towards the origin; the last `pairs` targets fly beside the first ones."""
    count = scene.targets - scene.pairs
    start_range = rng.uniform(*scene.start_range_m, count)
    bearing = rng.uniform(0.0, 2.0 * np.pi, count)
    height = rng.uniform(*scene.height_m, count)
    start = start_range[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    aim = rng.uniform(-0.5, 0.5, (count, 2)) * scene.aim_square_m
    heading = (aim - start) / np.linalg.norm(aim - start, axis=1, keepdims=True)
    beside = np.stack([-heading[:, 1], heading[:, 0]], axis=1)[: scene.pairs]
    side = rng.choice([-1.0, 1.0], scene.pairs)[:, None] * scene.pair_spacing_m
    start = np.concatenate([start, start[: scene.pairs] + side * beside])
    heading = np.concatenate([heading, heading[: scene.pairs]])
    height = np.concatenate([height, height[: scene.pairs]])
    time = np.arange(scene.scans) * scene.scan_interval_s
    ground = start + scene.speed_m_s * time[:, None, None] * heading
    level = np.broadcast_to(height[:, None], (scene.scans, scene.targets, 1))
    return np.concatenate([ground, level], axis=2)


def _drift(scene: RaladScene, rng: np.random.Generator) -> FloatArray:
    """Biases of each scan, shape (scans, 6): constant, or a random walk."""
    rate = scene.drift_rate
    if not rate.any():
        return np.tile(scene.bias, (scene.scans, 1))
    steps = rng.standard_normal((scene.scans, 6)) * np.sqrt(rate * scene.scan_interval_s)
    steps[0] = 0.0
    return scene.bias + np.cumsum(steps, axis=0)


def _pairing(scene: RaladScene, rng: np.random.Generator) -> IntArray:
    """Target whose report sensor j puts in each row: exchanged in a share of a pair's scans."""
    partner = np.tile(np.arange(scene.targets), (scene.scans, 1))
    wrong = round(scene.exchanged_share * scene.scans)
    for first in range(scene.pairs):
        second = scene.targets - scene.pairs + first
        scans = rng.choice(scene.scans, wrong, replace=False)
        partner[scans, first], partner[scans, second] = second, first
    return partner
