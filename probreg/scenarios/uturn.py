"""A target that makes a U-turn, seen by a sensor whose position bias drifts: the MH paper's scene.

Source: Zhou, Liang and Pan, Systems Engineering and Electronics 34(3), 2012, section 4. With
one sensor and an unknown target the bias is unobservable, so there is always a second report:
of a known target (form "reference"), or of a second, calibrated sensor (form "pair").
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors import PositionSensor
from probreg.sensors.reports import AssociatedReports
from probreg.typing import FloatArray

Form = Literal["reference", "pair"]
REFERENCE_VARIANCE_M2 = 1e-6  # of a position that is known


@dataclass(frozen=True)
class UturnScene:
    """Every number of the scene.

    The diameter of the turn is 2 v^2 / a; the paper prints another letter for the speed.
    """

    form: Form = "reference"
    drifting: bool = True
    start_m: tuple[float, float] = (-20_000.0, 0.0)
    speed_m_s: float = 300.0
    acceleration_m_s2: float = 20.0
    scans: int = 180
    interval_s: float = 1.0
    noise_variance_m2: float = 4_000.0
    drift_variance_m2: float = 1_000.0
    constant_bias_m: tuple[float, float] = (150.0, 200.0)

    def __post_init__(self) -> None:
        if self.form not in ("reference", "pair"):
            raise InvalidInputError(f"form is {self.form!r}; known: 'reference', 'pair'.")
        if self.scans < 1 or self.drift_variance_m2 < 0.0:
            raise InvalidInputError("scans must be 1 or more and drift_variance_m2 not negative.")

    @property
    def sensors(self) -> tuple[PositionSensor, PositionSensor]:
        """The biased sensor, and what it is compared with."""
        own = self.noise_variance_m2
        other = REFERENCE_VARIANCE_M2 if self.form == "reference" else own
        return (
            PositionSensor(((own, 0.0), (0.0, own)), "sensor"),
            PositionSensor(((other, 0.0), (0.0, other)), "reference"),
        )


@dataclass(frozen=True, eq=False)
class UturnTruth:
    """Ground truth, hidden from the estimators.

    Attributes
    ----------
    bias : ndarray, shape (T, 2)
        Of the sensor, at each scan; the reference has none.
    positions : ndarray, shape (T, 2)
    """

    bias: FloatArray
    positions: FloatArray


def fly(scene: UturnScene, time: FloatArray) -> FloatArray:
    """True positions (T, 2) at times (T,): along x, half a circle, and back."""
    x0, y0 = scene.start_m
    v = scene.speed_m_s
    omega, radius = scene.acceleration_m_s2 / v, v**2 / scene.acceleration_m_s2
    begin = -x0 / v
    end = begin + np.pi / omega
    angle = omega * (time - begin)
    positions = np.stack([radius * np.sin(angle), y0 - radius * (1.0 - np.cos(angle))], axis=1)
    before, after = time <= begin, time > end
    positions[before] = np.stack([x0 + v * time[before], np.full(before.sum(), y0)], axis=1)
    back = -v * (time[after] - end)
    positions[after] = np.stack([back, np.full(after.sum(), y0 - 2.0 * radius)], axis=1)
    return positions


def simulate(scene: UturnScene, rng: np.random.Generator) -> tuple[AssociatedReports, UturnTruth]:
    """Draw the bias and both reports of each scan, from the first interval on.

    A drifting bias starts from zero before the first scan.
    """
    time = scene.interval_s * np.arange(1, scene.scans + 1)
    positions = fly(scene, time)
    steps = rng.standard_normal((scene.scans, 2))
    if scene.drifting:
        bias = np.cumsum(np.sqrt(scene.drift_variance_m2) * steps, axis=0)
    else:
        bias = np.tile(scene.constant_bias_m, (scene.scans, 1))
    sensor, reference = scene.sensors
    values = (
        positions + bias + sensor.sample_noise(rng, scene.scans),
        positions + reference.sample_noise(rng, scene.scans),
    )
    return AssociatedReports(scene.sensors, values, time), UturnTruth(bias, positions)
