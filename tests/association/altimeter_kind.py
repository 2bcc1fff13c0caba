"""A kind of sensor of heights, such as those that an aircraft's transponder reports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors import Kind
from probreg.sensors.axes import HeightAxes


@dataclass(frozen=True)
class Altimeter:
    sigma_height: float
    name: str = "heights"

    kind: ClassVar[Kind] = Kind("altimeter", ("height_m",), {"sigma_height_m": "sigma_height"})
    dim: ClassVar[int] = 3
    bias_names: ClassVar[tuple[str, ...]] = ("height",)
    bias_units: ClassVar[tuple[str, ...]] = ("m",)
    position: ClassVar[None] = None
    azimuth_column: ClassVar[int | None] = None
    from_north: ClassVar[bool] = False
    gives_position: ClassVar[bool] = False
    cartesian: ClassVar[bool] = False

    @property
    def sigmas(self):
        return np.array([self.sigma_height])

    @property
    def bias_sd(self):
        return np.array([50.0])

    def check(self, reports):
        return reports

    def to_cartesian(self, reports, own=None, *, unbiased=True):
        return np.full((len(reports), 3), np.nan)

    def axes(self, site=None):
        return HeightAxes()
