"""A range that is wrong in proportion, as from a clock rate or the refractive index."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from probreg.sensors import Sensor
from probreg.sensors.terms._term import Term, component
from probreg.typing import FloatArray


@dataclass(frozen=True)
class RangeGain(Term):
    """A range that is wrong in proportion, as from a clock rate or the refractive index."""

    @property
    def name(self) -> str:
        """Name of the term."""
        return "range_gain"

    @property
    def unit(self) -> str:
        """Unit of the coefficient."""
        return "m/m"

    @property
    def prior_sd(self) -> float:
        """One part in a thousand."""
        return 1e-3

    @classmethod
    def of(cls, sensor: Sensor) -> tuple[Self, ...]:
        """Sensors that report range."""
        return (cls(sensor),) if "range" in sensor.bias_names else ()

    def column(self, reports: FloatArray) -> FloatArray:
        """The range, in the range."""
        rho = reports[:, self.sensor.bias_names.index("range")]
        return component(self.sensor, "range", rho, len(reports))
