"""A recorded heading of the platform that is off, for every sensor that counts from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from probreg.sensors import Sensor, sense
from probreg.sensors.terms._term import Term
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Heading(Term):
    """A recorded heading of the platform that is off, counter-clockwise positive.

    One coefficient, "platform.heading", for all sensors of a recording's platform. It moves
    the azimuths of one sensor just as that sensor's own offset does.
    """

    varies: ClassVar[bool] = False

    @property
    def name(self) -> str:
        """Name of the term."""
        return "heading"

    @property
    def unit(self) -> str:
        """Unit of the coefficient."""
        return "rad"

    @property
    def prior_sd(self) -> float:
        """One degree."""
        return float(np.deg2rad(1.0))

    @property
    def owner(self) -> str:
        """The platform."""
        return "platform"

    @classmethod
    def of(cls, sensor: Sensor) -> tuple[Self, ...]:
        """Sensors that report an azimuth."""
        return () if sensor.azimuth_column is None else (cls(sensor),)

    def column(self, reports: FloatArray) -> FloatArray:
        """One in the azimuth, minus one where it counts clockwise."""
        column = np.zeros((len(reports), len(self.sensor.bias_names)))
        column[:, self.sensor.azimuth_column] = sense(self.sensor)
        return column
