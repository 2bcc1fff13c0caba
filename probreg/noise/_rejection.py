"""Laws that reject: weights without a density."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from probreg.errors import ImproperLawError
from probreg.noise._law import NoiseLaw
from probreg.typing import FloatArray


class RejectionRule(NoiseLaw):
    """A law whose weight falls to zero: its loss has a ceiling, so no density belongs to it."""

    proper: ClassVar[bool] = False
    convex: ClassVar[bool] = False

    def sample_unit(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """There is nothing to draw from.

        Raises
        ------
        ImproperLawError
            Always.
        """
        raise ImproperLawError(self._no_density("sampled"))
