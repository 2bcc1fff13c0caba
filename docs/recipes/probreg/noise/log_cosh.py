"""The log-cosh law: quadratic in the centre, absolute deviation in the tails."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from probreg.noise._checks import above_zero
from probreg.noise._law import NoiseLaw
from probreg.typing import FloatArray


@dataclass(frozen=True)
class LogCosh(NoiseLaw):
    """Density proportional to 1 / cosh(d), weight tanh(d) / d.

    Parameters
    ----------
    scale : float or array
        Factor on the square root of R.
    componentwise : bool
        Whether every whitened component has its own d instead of one radius.
    """

    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    def __post_init__(self) -> None:
        above_zero(self, scale=self.scale)

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """tanh(d) / d."""
        d = np.sqrt(d2) + 1e-12
        return np.tanh(d) / d

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """Minus log cosh(d), which does not overflow in this form."""
        d = np.sqrt(d2)
        return -(d + np.log1p(np.exp(-2.0 * d)) - np.log(2.0))

    def sample_unit(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """Rejection of the radius from a gamma law, in a uniform direction."""
        radius = np.empty(0)
        while len(radius) < n:
            proposed = rng.standard_gamma(m, 2 * n + 10)
            accepted = rng.random(len(proposed)) < 1.0 / (1.0 + np.exp(-2.0 * proposed))
            radius = np.concatenate([radius, proposed[accepted]])
        direction = rng.standard_normal((n, m))
        return radius[:n, None] * direction / np.linalg.norm(direction, axis=1, keepdims=True)
