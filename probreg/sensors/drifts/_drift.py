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

    def between(
        self,
        ends: tuple[FloatArray, FloatArray],
        share: FloatArray,
        size: FloatArray,
        rng: np.random.Generator,
    ) -> FloatArray:
        """Draw values (k, n) between two times at which they are known.

        Parameters
        ----------
        ends : tuple of ndarray, shape (k, n)
            Values at the time before and at that after.
        share : ndarray, shape (n,)
            Of the interval that has passed, 0 to 1.
        size : ndarray, shape (k, n)
            Standard deviation of the change within the interval.
        """
        bridge = np.sqrt(share * (1.0 - share)) * size * rng.standard_normal(size.shape)
        return np.asarray(ends[0] * (1.0 - share) + ends[1] * share + bridge)


def increments(size: FloatArray) -> FloatArray:
    """Root (T, T - 1) of a sum of steps whose scales are `size` (T - 1,), from zero."""
    T = len(size) + 1
    later = np.arange(T)[:, None] > np.arange(T - 1)
    return np.asarray(np.where(later, size, 0.0))
