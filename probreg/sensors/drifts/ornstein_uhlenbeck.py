"""A deviation that returns to its level: the Ornstein-Uhlenbeck process."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors.drifts._drift import Drift
from probreg.typing import FloatArray


@dataclass(frozen=True)
class OrnsteinUhlenbeck(Drift):
    """Stationary deviations that are forgotten with a time constant, by default ten minutes.

    Parameters
    ----------
    time_constant_s : float
    """

    time_constant_s: float = 600.0
    name: ClassVar[str] = "ou"
    meaning: ClassVar[str] = "standard deviation about the level"

    def root(self, time: FloatArray) -> FloatArray:
        """Each deviation is a share of the one before and something new."""
        kept = np.exp(-np.diff(time) / self.time_constant_s)
        new = np.sqrt(np.concatenate([[1.0], 1.0 - kept**2]))
        root = np.zeros((len(time), len(time)))
        root[0, 0] = new[0]
        for k in range(1, len(time)):
            root[k] = kept[k - 1] * root[k - 1]
            root[k, k] = new[k]
        return root

    def step_variance(self, interval: FloatArray) -> FloatArray:
        """Twice what is forgotten."""
        return np.asarray(2.0 * (1.0 - np.exp(-interval / self.time_constant_s)))
