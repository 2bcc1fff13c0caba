"""A height that is wrong in proportion, as by pressure in air that is warm or cold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from probreg.sensors import Sensor
from probreg.sensors.terms._term import Term, component
from probreg.typing import FloatArray


@dataclass(frozen=True)
class HeightGain(Term):
    """A height that is wrong in proportion, as by pressure in air that is warm or cold."""

    @property
    def name(self) -> str:
        """Name of the term."""
        return "height_gain"

    @property
    def unit(self) -> str:
        """Unit of the coefficient."""
        return "m/m"

    @property
    def prior_sd(self) -> float:
        """Two parts in a hundred: five degrees of temperature."""
        return 0.02

    @classmethod
    def of(cls, sensor: Sensor) -> tuple[Self, ...]:
        """Sensors that report height."""
        return (cls(sensor),) if "height" in sensor.bias_names else ()

    def column(self, reports: FloatArray) -> FloatArray:
        """The height, in the height."""
        height = reports[:, self.sensor.bias_names.index("height")]
        return component(self.sensor, "height", height, len(reports))
