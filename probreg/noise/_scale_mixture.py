"""Laws in which a precision is hidden: Gaussian given it, so that Gibbs samplers can draw it."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from probreg.noise._law import NoiseLaw, Size
from probreg.typing import FloatArray


class ScaleMixture(NoiseLaw):
    """A law that is Gaussian given a positive random precision."""

    scale_mixture: ClassVar[bool] = True

    @abstractmethod
    def draw_unit_precision(self, rng: np.random.Generator, d2: FloatArray, m: Size) -> FloatArray:
        """Draw the precision given the squared norm, at unit scale."""

    def draw_precision(
        self, rng: np.random.Generator, v: FloatArray, m: Size | None = None
    ) -> FloatArray:
        """Draw the precisions of rows given their whitened residuals: the Gibbs step.

        Their conditional mean is the equivalent weight; shapes as for `weight`.
        """
        law = self._spread()
        d2, size = law.squared_norm(v, m)
        return law.draw_unit_precision(rng, d2, size) / np.asarray(law.unit) ** 2
