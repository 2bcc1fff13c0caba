"""A distant emitter and a straight track: the scene of the robust total-least-squares paper.

Source: Wu, Chen, Zhang, Zhang and Ni, J. Central South Univ. 46(3), 2015, section 3. The
paper's table of outliers is lost; this one reproduces the paper's own figures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.scenarios._passive import OutlierTable, PassiveTruth, report, sizes
from probreg.sensors import BearingSensor
from probreg.sensors.reports import BearingReports

TABLE: OutlierTable = (
    (101, 110, -3.0),
    *((point, point, -30.0) for point in (120, 130, 140, 150)),
    (180, 180, -60.0),
)


@dataclass(frozen=True)
class RrtlsScene:
    """Every number of the scene; angles in degrees, as named.

    `outliers` are numbered by point, from 1, and added to the noise; in addition, a random
    share `contamination` of the points has `contamination_size` standard deviations added.
    The speed is not in the paper; nothing depends on it.
    """

    sigma_deg: float = 0.6
    outliers: OutlierTable = ()
    contamination: float = 0.0
    contamination_size: float = -40.0
    emitter_m: tuple[float, float] = (30_000.0, 180_000.0)
    spacing_m: float = 300.0
    points: int = 200
    interval_s: float = 1.0
    bias_deg: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.contamination < 1.0:
            raise InvalidInputError(f"contamination is {self.contamination}, not in [0, 1).")

    @property
    def sensor(self) -> BearingSensor:
        """The direction finder."""
        return BearingSensor(np.deg2rad(self.sigma_deg))


def simulate(scene: RrtlsScene, rng: np.random.Generator) -> tuple[BearingReports, PassiveTruth]:
    """Draw one flight; one seed gives the same noise whatever the outliers."""
    number = np.arange(scene.points)
    own = np.stack([scene.spacing_m * number, np.zeros(scene.points)], axis=1)
    size = sizes(scene.outliers, number + 1)
    error = rng.standard_normal(scene.points)
    struck = rng.random(scene.points) < scene.contamination
    size = size + np.where(struck, scene.contamination_size, 0.0)
    time = scene.interval_s * number
    bias = np.deg2rad(scene.bias_deg)
    return report(scene.sensor, scene.emitter_m, own, time, bias, error + size, size != 0.0)
