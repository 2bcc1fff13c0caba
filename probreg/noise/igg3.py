"""IGG-III: full weight, then falling weight, then rejection."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise._checks import above_zero
from probreg.noise._rejection import RejectionRule
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Igg3(RejectionRule):
    """The IGG-III equivalent weight of geodesy, used by the bearings-only papers.

    Parameters
    ----------
    k0, k1 : float
        Where the weight starts to fall and where it reaches zero, standard deviations.
    scale : float or array
        Factor on the square root of R.
    componentwise : bool
        Weigh every whitened component on its own.

    References
    ----------
    Wu et al., J. Central South Univ. 46(3), 2015, section 2.2.
    """

    k0: float = 1.5
    k1: float = 5.0
    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    def __post_init__(self) -> None:
        above_zero(self, k0=self.k0, k1=self.k1, scale=self.scale)
        if self.k1 <= self.k0:
            raise InvalidInputError(f"Igg3: k1 {self.k1!r} must be above k0 {self.k0!r}.")

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """1 up to k0, falling, 0 from k1."""
        k0, k1, d = params[0], params[1], np.sqrt(d2)
        if d <= k0:
            return 1.0
        if d >= k1:
            return 0.0
        return k0 / d * ((k1 - d) / (k1 - k0)) ** 2

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """Minus the loss whose influence function is w d: parabola, cubic, constant."""
        k0, span, d = params[0], params[1] - params[0], np.sqrt(d2)
        inner = np.minimum(d, k0)
        falling = np.minimum(np.maximum(d, k0), params[1])
        return -0.5 * inner**2 - k0 * (span**3 - (params[1] - falling) ** 3) / (3.0 * span**2)

    @property
    def params(self) -> tuple[Any, ...]:
        """(k0, k1)."""
        return (self.k0, self.k1)

    @property
    def corners(self) -> tuple[float, ...]:
        """Both thresholds."""
        return (self.k0, self.k1)
