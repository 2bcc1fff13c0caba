"""A range error that grows with the square of the range, as from a wrong signal speed profile."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from probreg.sensors import Sensor
from probreg.sensors.terms._term import Term, component
from probreg.typing import FloatArray

REFERENCE_M = 100_000.0  # where the coefficient is the error itself


@dataclass(frozen=True)
class RangeSquare(Term):
    """The coefficient is the error in metres at 100 km."""

    @property
    def name(self) -> str:
        """Name of the term."""
        return "range_square"

    @property
    def unit(self) -> str:
        """Unit of the coefficient."""
        return "m"

    @property
    def prior_sd(self) -> float:
        """50 m at 100 km."""
        return 50.0

    @classmethod
    def of(cls, sensor: Sensor) -> tuple[Self, ...]:
        """Sensors that report range."""
        return (cls(sensor),) if "range" in sensor.bias_names else ()

    def column(self, reports: FloatArray) -> FloatArray:
        """The square of the range over that of the reference, in the range."""
        rho = reports[:, self.sensor.bias_names.index("range")]
        return component(self.sensor, "range", (rho / REFERENCE_M) ** 2, len(reports))
