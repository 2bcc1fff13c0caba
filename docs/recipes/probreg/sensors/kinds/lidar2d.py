"""A scanning lidar: range and azimuth in the plane, with small biases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors._kind import Kind
from probreg.sensors._sensor import settle
from probreg.sensors.kinds._polar import PolarSensor
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Lidar2D(PolarSensor):
    """A lidar that reports (range, azimuth); parameters as for `Radar2D`."""

    position: tuple[float, float]
    sigma_range: float
    sigma_azimuth: float
    name: str = "lidar"
    from_north: bool = False

    dim: ClassVar[int] = 2
    bias_names: ClassVar[tuple[str, ...]] = ("range", "azimuth")
    bias_units: ClassVar[tuple[str, ...]] = ("m", "rad")
    kind: ClassVar[Kind] = Kind(
        "lidar2d",
        ("range_m", "azimuth_deg"),
        {"sigma_range_m": "sigma_range", "sigma_azimuth_deg": "sigma_azimuth"},
        coordinates=2,
    )

    def __post_init__(self) -> None:
        settle(self, 2, "sigma_range", "sigma_azimuth")

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations of the report components, metres and radians."""
        return np.array([self.sigma_range, self.sigma_azimuth])

    @property
    def principal(self) -> tuple[FloatArray, None]:
        """Accuracies of the components, whose errors are independent."""
        return self.sigmas, None

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 10 cm and half a degree of mounting error."""
        return np.array([0.1, np.deg2rad(0.5)])
