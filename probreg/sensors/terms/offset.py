"""A constant added to one report component."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from probreg.sensors import Sensor
from probreg.sensors.terms._term import Term, component
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Offset(Term):
    """A constant added to one report component: "range", "azimuth", "x", ...

    Parameters
    ----------
    sensor : Sensor
    part : str
        The component.
    """

    part: str

    varies: ClassVar[bool] = False

    @property
    def name(self) -> str:
        """Of the component."""
        return self.part

    @property
    def unit(self) -> str:
        """Of the component."""
        return self.sensor.bias_units[self.sensor.bias_names.index(self.part)]

    @property
    def prior_sd(self) -> float:
        """What such sensors are found to have."""
        return float(self.sensor.bias_sd[self.sensor.bias_names.index(self.part)])

    @classmethod
    def of(cls, sensor: Sensor) -> tuple[Self, ...]:
        """One for each report component."""
        return tuple(cls(sensor, name) for name in sensor.bias_names)

    def column(self, reports: FloatArray) -> FloatArray:
        """One in the component."""
        return component(self.sensor, self.part, 1.0, len(reports))
