"""Steps now and then, and rest between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors.drifts._drift import HOUR_S, Drift, increments
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Steps(Drift):
    """A Cauchy process: a few large steps make up nearly all of the change.

    Changes are Cauchy with a scale in proportion to time, so that the process does not depend on
    where it is looked at.
    """

    name: ClassVar[str] = "steps"
    freedom: ClassVar[float] = 1.0
    meaning: ClassVar[str] = "scale of the change within an hour"

    def root(self, time: FloatArray) -> FloatArray:
        """Sums of independent steps."""
        return increments(np.sqrt(self.step_variance(np.diff(time))))

    def step_variance(self, interval: FloatArray) -> FloatArray:
        """Squared scale."""
        return np.asarray((interval / HOUR_S) ** 2)

    def between(
        self,
        ends: tuple[FloatArray, FloatArray],
        share: FloatArray,
        size: FloatArray,
        rng: np.random.Generator,
    ) -> FloatArray:
        """A step is over or still to come."""
        return np.where(rng.random(size.shape) < share, ends[1], ends[0])
