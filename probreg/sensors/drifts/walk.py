"""A random walk."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors.drifts._drift import HOUR_S, Drift, increments
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Walk(Drift):
    """A random walk: the variance of the change grows in proportion to time."""

    name: ClassVar[str] = "walk"

    def root(self, time: FloatArray) -> FloatArray:
        """Sums of independent steps."""
        return increments(np.sqrt(self.step_variance(np.diff(time))))

    def step_variance(self, interval: FloatArray) -> FloatArray:
        """One in an hour."""
        return np.asarray(interval / HOUR_S)
