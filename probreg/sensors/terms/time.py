"""A clock that is ahead: the stamp is the true time plus the offset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from probreg.sensors import Sensor
from probreg.sensors.terms._term import Term
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Time(Term):
    """A clock that is ahead: the stamp is the true time plus the offset.

    At the stamped time the target has moved on, so the position lags by velocity times offset.
    """

    stamp: ClassVar[float] = 1.0

    @property
    def name(self) -> str:
        """Name of the term."""
        return "time"

    @property
    def unit(self) -> str:
        """Unit of the coefficient."""
        return "s"

    @property
    def prior_sd(self) -> float:
        """Half a second."""
        return 0.5

    @classmethod
    def of(cls, sensor: Sensor) -> tuple[Self, ...]:
        """Every sensor."""
        return (cls(sensor),)

    def column(self, reports: FloatArray) -> FloatArray:
        """Zero: the reports themselves are right."""
        return np.zeros((len(reports), len(self.sensor.bias_names)))
