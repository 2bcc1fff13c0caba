"""An eccentric azimuth encoder: the sine of the azimuth, added to the azimuth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from probreg.sensors import Sensor
from probreg.terms._term import Term, component
from probreg.typing import FloatArray


@dataclass(frozen=True)
class AzimuthSine(Term):
    """An eccentric azimuth encoder: the sine of the azimuth, added to the azimuth."""

    @property
    def name(self) -> str:
        """Name of the term."""
        return "azimuth_sine"

    @property
    def unit(self) -> str:
        """Unit of the coefficient."""
        return "rad"

    @property
    def prior_sd(self) -> float:
        """A tenth of a degree or two."""
        return float(np.deg2rad(0.2))

    @classmethod
    def of(cls, sensor: Sensor) -> tuple[Self, ...]:
        """Sensors that report azimuth."""
        return (cls(sensor),) if "azimuth" in sensor.bias_names else ()

    def column(self, reports: FloatArray) -> FloatArray:
        """The sine of the azimuth, in the azimuth."""
        azimuth = reports[:, self.sensor.bias_names.index("azimuth")]
        return component(self.sensor, "azimuth", np.sin(azimuth), len(reports))
