"""A wave in azimuth, as an eccentric encoder or an antenna that is not level makes it."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np

from probreg.sensors import Sensor
from probreg.sensors.terms._term import Term, component
from probreg.typing import FloatArray


@dataclass(frozen=True)
class AzimuthWave(Term):
    """A function of the azimuth, added to the azimuth."""

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

    @abstractmethod
    def wave(self, azimuth: FloatArray) -> FloatArray:
        """The function (n,) of azimuths (n,)."""

    def column(self, reports: FloatArray) -> FloatArray:
        """The wave, in the azimuth."""
        azimuth = reports[:, self.sensor.bias_names.index("azimuth")]
        return component(self.sensor, "azimuth", self.wave(azimuth), len(reports))
