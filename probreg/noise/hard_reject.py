"""Hard rejection: a row counts fully or not at all."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from probreg.noise._checks import above_zero
from probreg.noise._rejection import RejectionRule
from probreg.typing import FloatArray


@dataclass(frozen=True)
class HardReject(RejectionRule):
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

    kinked: ClassVar[bool] = True

    def __post_init__(self) -> None:
        above_zero(self, k=self.k, scale=self.scale)

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """1 up to k, 0 beyond."""
        return 1.0 if d2 <= params[0] * params[0] else 0.0

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """-d^2 / 2, constant beyond k."""
        return -0.5 * np.minimum(d2, params[0] ** 2)

    @property
    def params(self) -> tuple[Any, ...]:
        """(k,)."""
        return (self.k,)

    @property
    def corners(self) -> tuple[float, ...]:
        """The threshold."""
        return (self.k,)
