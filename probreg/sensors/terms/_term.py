"""What every bias term offers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from probreg.sensors import Sensor
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Term(ABC):
    """A systematic error of a sensor, linear in one unknown coefficient.

    Parameters
    ----------
    sensor : Sensor

    Attributes
    ----------
    name : str
        As in a setup, such as "range" or "range_gain".
    unit : str
        Of the coefficient: "m", "rad", "s" or "m/m".
    stamp : float
        Derivative of the report's time stamp by the coefficient.
    varies : bool
        Whether its effect depends on where the target is, or how it moves.
    """

    sensor: Sensor
    stamp: ClassVar[float] = 0.0
    varies: ClassVar[bool] = True

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the term."""

    @property
    @abstractmethod
    def unit(self) -> str:
        """Unit of the coefficient."""

    @property
    @abstractmethod
    def prior_sd(self) -> float:
        """Default prior standard deviation of the coefficient."""

    @property
    def owner(self) -> str:
        """What the coefficient belongs to: terms of equal owner and name share it."""
        return self.sensor.name

    @classmethod
    @abstractmethod
    def of(cls, sensor: Sensor) -> tuple[Self, ...]:
        """The terms of this kind that a sensor can have."""

    @abstractmethod
    def column(self, reports: FloatArray) -> FloatArray:
        """Derivative (n, q) of true reports (n, q) by the coefficient."""


def component(sensor: Sensor, name: str, values: FloatArray | float, n: int) -> FloatArray:
    """A column (n, q) that is zero but in one report component."""
    column = np.zeros((n, len(sensor.bias_names)))
    column[:, sensor.bias_names.index(name)] = values
    return column
