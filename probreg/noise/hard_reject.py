"""Hard rejection: a row counts fully or not at all."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from probreg.noise._law import NoiseLaw, Size, WeightFunction, above_zero
from probreg.typing import FloatArray


def _weight(d2: float, m: float, params: FloatArray) -> float:
    return 1.0 if d2 <= params[0] * params[0] else 0.0


@dataclass(frozen=True)
class HardReject(NoiseLaw):
    """Weight 1 up to k, 0 beyond.

    Parameters
    ----------
    k : float
        Threshold in standard deviations.
    scale : float or array
        Factor on the square root of R.
    componentwise : bool
        Reject every whitened component on its own.
    """

    k: float = 3.0
    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    proper: ClassVar[bool] = False
    convex: ClassVar[bool] = False
    kinked: ClassVar[bool] = True
    weight_function: ClassVar[WeightFunction] = staticmethod(_weight)

    def __post_init__(self) -> None:
        above_zero(self, k=self.k, scale=self.scale)

    @property
    def params(self) -> tuple[Any, ...]:
        """(k,)."""
        return (self.k,)

    @property
    def corners(self) -> tuple[float, ...]:
        """The threshold."""
        return (self.k,)

    def log_kernel(self, d2: Any, m: Size) -> Any:
        """-min(d, k)^2 / 2."""
        return np.where(np.real(d2) <= self.k**2, -0.5 * d2, -0.5 * self.k**2)
