"""An aircraft passes an emitter: the scene of the robust EKF paper.

Source: Zhang, Chen, Wu and Zhang, J. Air Force Engineering Univ. 15(4), 2014, section 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from probreg.errors import InvalidInputError
from probreg.scenarios._passive import OutlierTable, PassiveTruth, report, sizes
from probreg.sensors import BearingSensor
from probreg.sensors.reports import BearingReports

# none; or noise of that many times the standard deviation, as the paper's table is titled;
# or an error of that many standard deviations to one side, which fits the paper's curves
Reading = Literal["none", "random", "one_sided"]
READINGS: tuple[Reading, ...] = ("none", "random", "one_sided")


@dataclass(frozen=True)
class RekfScene:
    """Every number of the scene; angles in degrees, as named.

    Outliers are numbered by their time in seconds.
    """

    sigma_deg: float = 0.1
    outliers: Reading = "none"
    emitter_m: tuple[float, float] = (5_000.0, 10_000.0)
    speed_m_s: float = 600.0
    interval_s: float = 1.0
    duration_s: float = 200.0
    bias_deg: float = 0.0
    table: OutlierTable = ((100, 110, 5.0), (130, 130, 10.0), (140, 140, 20.0), (160, 160, 25.0))

    def __post_init__(self) -> None:
        if self.outliers not in READINGS:
            raise InvalidInputError(f"outliers is {self.outliers!r}; known: {READINGS}.")

    @property
    def sensor(self) -> BearingSensor:
        """The direction finder."""
        return BearingSensor(np.deg2rad(self.sigma_deg))


def simulate(scene: RekfScene, rng: np.random.Generator) -> tuple[BearingReports, PassiveTruth]:
    """Draw one flight along +x from the origin; the noise is the same for every reading."""
    time = scene.interval_s * np.arange(round(scene.duration_s / scene.interval_s) + 1)
    own = np.stack([scene.speed_m_s * time, np.zeros(len(time))], axis=1)
    size = sizes(scene.table if scene.outliers != "none" else (), np.rint(time).astype(int))
    error = rng.standard_normal(len(time))
    outlier = size != 0.0
    error = np.where(outlier, size * error, error) if scene.outliers == "random" else error + size
    bias = np.deg2rad(scene.bias_deg)
    return report(scene.sensor, scene.emitter_m, own, time, bias, error, outlier)
