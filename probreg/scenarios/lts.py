"""Fifteen targets, false alarms and missed detections: the scene of the LTS paper.

Source: Tian and Huang, J. Electronics & Information Technology 40(3), 2018, section 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.association import Objective
from probreg.errors import InvalidInputError
from probreg.sensors import Tracker2D
from probreg.sensors.reports import SensorReports
from probreg.typing import FloatArray, IntArray

NOMINAL_SIGMA_M = 1.0  # scale of the rows where the noise is zero


@dataclass(frozen=True)
class LtsScene:
    """Every number of the scene; angles in degrees and lengths in metres, as named.

    The gate and the objective of the association are not in the paper.
    """

    sigma_m: float = 100.0
    centre_m: tuple[float, float] = (0.0, 80_000.0)
    side_m: float = 40_000.0
    targets: int = 15
    detection: float = 0.96
    false_alarms: float = 2.0
    baseline_m: float = 100_000.0
    bias_range_m: float = 1_000.0
    bias_azimuth_deg: float = 1.0
    gate_m: float = 8_000.0
    objective: Objective = "cost"

    def __post_init__(self) -> None:
        if not 0.0 <= self.detection <= 1.0 or self.sigma_m < 0.0 or self.false_alarms < 0.0:
            raise InvalidInputError(
                "detection is a probability, sigma_m and false_alarms are zero or more."
            )

    @property
    def sensors(self) -> tuple[Tracker2D, Tracker2D]:
        """A at the origin and B on the x axis, azimuth from north."""
        sigma = max(self.sigma_m, NOMINAL_SIGMA_M)
        return (
            Tracker2D((0.0, 0.0), sigma, "A", from_north=True),
            Tracker2D((self.baseline_m, 0.0), sigma, "B", from_north=True),
        )

    @property
    def bias(self) -> FloatArray:
        """True biases (4,): range and azimuth of A, then the opposite of B."""
        own = np.array([self.bias_range_m, np.deg2rad(self.bias_azimuth_deg)])
        return np.concatenate([own, -own])


# the text puts the square at (0, 80) km; with it a third of the runs have more than a quarter
# of wrong pairs. A square between the sensors, likely meant, has fewer.
READINGS = {
    "literal": LtsScene(),
    "symmetric": LtsScene(centre_m=(50_000.0, 80_000.0), gate_m=6_000.0, objective="cardinality"),
}


@dataclass(frozen=True, eq=False)
class LtsTruth:
    """Ground truth, hidden from the estimators.

    Attributes
    ----------
    bias : ndarray, shape (4,)
    positions : ndarray, shape (targets, 2)
    targets : tuple of two ndarray of int
        Target number of each report of A and B; -1 for a false alarm.
    """

    bias: FloatArray
    positions: FloatArray
    targets: tuple[IntArray, IntArray]

    def common(self) -> IntArray:
        """Targets that both sensors detected."""
        both = np.intersect1d(*self.targets)
        return both[both >= 0]

    def right_pairs(self) -> IntArray:
        """Report numbers (k, 2) of the common targets."""
        columns = [np.flatnonzero(np.isin(t, self.common())) for t in self.targets]
        ordered = [c[np.argsort(t[c])] for c, t in zip(columns, self.targets, strict=True)]
        return np.stack(ordered, axis=1)


def simulate(
    scene: LtsScene, rng: np.random.Generator
) -> tuple[tuple[SensorReports, SensorReports], LtsTruth]:
    """Draw one frame; the same generator state gives the same frame at every noise level.

    Parameters
    ----------
    scene : LtsScene
    rng : numpy.random.Generator

    Returns
    -------
    data : tuple of two SensorReports
        Reports of A and B in random order, not associated.
    truth : LtsTruth
    """
    half = 0.5 * scene.side_m
    centre = np.array(scene.centre_m)
    positions = centre + rng.uniform(-half, half, (scene.targets, 2))
    data, numbers = [], []
    for sensor, bias in zip(scene.sensors, scene.bias.reshape(2, 2), strict=True):
        detected = rng.random(scene.targets) < scene.detection
        noise = scene.sigma_m * rng.standard_normal((scene.targets, 2))
        alarms = centre + rng.uniform(-half, half, (rng.poisson(scene.false_alarms), 2))
        seen = sensor.to_cartesian(sensor.to_report(positions) + bias) + noise
        found = np.concatenate([seen[detected], alarms])
        number = np.concatenate([np.flatnonzero(detected), np.full(len(alarms), -1)])
        order = rng.permutation(len(found))
        data.append(SensorReports(sensor, sensor.to_report(found[order])))
        numbers.append(number[order])
    return (data[0], data[1]), LtsTruth(scene.bias, positions, (numbers[0], numbers[1]))
