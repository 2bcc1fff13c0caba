"""Tukey's bisquare: smoothly redescending, zero beyond c."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from probreg.noise._checks import above_zero
from probreg.noise._rejection import RejectionRule
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Tukey(RejectionRule):
    """Weight (1 - d^2 / c^2)^2 up to c, 0 beyond.

    Parameters
    ----------
    c : float
        Rejection point in standard deviations; 4.685 is 95 % efficient in one dimension.
    scale : float or array
        Factor on the square root of R.
    componentwise : bool
        Weigh every whitened component on its own.
    """

    c: float = 4.685
    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    def __post_init__(self) -> None:
        above_zero(self, c=self.c, scale=self.scale)

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """(1 - d^2 / c^2)^2, 0 from c."""
        u2 = d2 / (params[0] * params[0])
        return (1.0 - u2) ** 2 if u2 < 1.0 else 0.0

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """Minus the bisquare loss, constant beyond c."""
        inner = np.minimum(d2 / params[0] ** 2, 1.0)
        return -(params[0] ** 2) / 6.0 * (1.0 - (1.0 - inner) ** 3)

    @property
    def params(self) -> tuple[Any, ...]:
        """(c,)."""
        return (self.c,)

    @property
    def corners(self) -> tuple[float, ...]:
        """The rejection point."""
        return (self.c,)
