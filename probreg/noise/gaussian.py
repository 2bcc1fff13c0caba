"""The Gaussian law: least squares."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from probreg.noise._checks import above_zero
from probreg.noise._law import Size
from probreg.noise._scale_mixture import Mixture, ScaleMixture
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Gaussian(ScaleMixture):
    """Gaussian noise, log kernel -d^2 / 2, weight 1.

    Parameters
    ----------
    scale : float or array
        Factor on the square root of R.
    componentwise : bool
        Same law either way; kept so that every law can be asked.
    """

    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    def __post_init__(self) -> None:
        above_zero(self, scale=self.scale)

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """1."""
        return 1.0

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """-d^2 / 2."""
        return -0.5 * d2

    def log_normalizer(self, m: int) -> float:
        """(m / 2) log 2 pi."""
        return 0.5 * m * float(np.log(2.0 * np.pi))

    def unit_covariance_factor(self, m: int) -> float:
        """1."""
        return 1.0

    def unit_information_factor(self, m: int) -> float:
        """1."""
        return 1.0

    def sample_unit(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """Standard normal vectors."""
        return rng.standard_normal((n, m))

    def draw_unit_precision(self, rng: np.random.Generator, d2: FloatArray, m: Size) -> FloatArray:
        """The precision is 1."""
        return np.ones_like(d2)

    def unit_mixture(self, m: int) -> Mixture:
        """One Gaussian."""
        return Mixture(np.ones(1), np.ones(1))
