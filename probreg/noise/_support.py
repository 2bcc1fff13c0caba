"""Where a parameter of a noise law may lie, its map to the whole line, its usual prior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import expit, logit

from probreg.typing import FloatArray

_LOG, _LOGIT = 100.0, 30.0  # free coordinates beyond which squares or complements lose all digits


@dataclass(frozen=True)
class Support:
    """An open interval: from `lower` to infinity through the log, or (0, 1) through the logit.

    Parameters
    ----------
    lower : float
    share : bool
        Whether the parameter is a share, in (0, 1).
    spread : float
        Standard deviation, in the free coordinate, of the prior that the parameter has unless
        another is given; its median is the law's default.
    """

    lower: float = 0.0
    share: bool = False
    spread: float = 0.5

    def holds(self, value: float) -> bool:
        """Whether a number lies inside."""
        return self.lower < value < (1.0 if self.share else np.inf)

    def free(self, value: FloatArray | float) -> FloatArray:
        """Natural to free coordinate."""
        if self.share:
            return np.asarray(logit(value))
        return np.asarray(np.log(np.asarray(value, dtype=float) - self.lower))

    def natural(self, free: FloatArray | float) -> FloatArray:
        """Free to natural coordinate, kept off the ends that rounding would reach."""
        x = np.asarray(free, dtype=float)
        if self.share:
            return np.asarray(expit(np.clip(x, -_LOGIT, _LOGIT)))
        stretched = np.exp(np.clip(x, -_LOG, _LOG))
        return np.maximum(self.lower + stretched, self.lower * (1.0 + 1e-12))

    def slope(self, free: FloatArray | float) -> FloatArray:
        """Derivative of the natural by the free coordinate: zero where it is held."""
        x = np.asarray(free, dtype=float)
        limit = _LOGIT if self.share else _LOG
        held = np.clip(x, -limit, limit)
        slope = expit(held) * expit(-held) if self.share else np.exp(held)
        return np.where(held == x, slope, 0.0)


POSITIVE = Support()
SHARE = Support(share=True, spread=1.0)
ABOVE_ONE = Support(lower=1.0, spread=0.7)
