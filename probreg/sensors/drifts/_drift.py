"""What every kind of drift offers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from probreg.typing import FloatArray

HOUR_S = 3600.0


class Drift(ABC):
    """How a coefficient deviates from its level: spread times independent parts through a root.

    Attributes
    ----------
    name : str
        As in a setup.
    freedom : float
        Degrees of freedom of the independent parts, Student's t; infinite if they are normal.
    meaning : str
        Of the spread, in words.
    """

    name: ClassVar[str]
    freedom: ClassVar[float] = np.inf
    meaning: ClassVar[str] = "standard deviation of the change within an hour"

    @abstractmethod
    def root(self, time: FloatArray) -> FloatArray:
        """Matrix (T, m) from independent parts to deviations at times (T,), of a spread of one."""

    @abstractmethod
    def step_variance(self, interval: FloatArray) -> FloatArray:
        """Variance of the change within short intervals, seconds, of a spread of one."""


def increments(size: FloatArray) -> FloatArray:
    """Root (T, T - 1) of a sum of steps whose scales are `size` (T - 1,), from zero."""
    T = len(size) + 1
    later = np.arange(T)[:, None] > np.arange(T - 1)
    return np.asarray(np.where(later, size, 0.0))
