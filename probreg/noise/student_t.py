"""The Student-t law: robust, redescending, a Gaussian scale mixture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.special import betaln, digamma, gammaln

from probreg.noise._checks import above_zero
from probreg.noise._law import Size
from probreg.noise._scale_mixture import ScaleMixture
from probreg.noise._support import POSITIVE, Support
from probreg.typing import FloatArray


@dataclass(frozen=True)
class StudentT(ScaleMixture):
    """Multivariate Student-t noise, weight (nu + m) / (nu + d^2).

    R is the scale matrix: the covariance is nu / (nu - 2) times it, for nu > 2.

    Parameters
    ----------
    nu : float or array
        Degrees of freedom.
    scale : float or array
        Factor on the square root of R.
    componentwise : bool
        Independent univariate t on every whitened component instead of one radius.
    """

    nu: Any = 4.0
    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    convex: ClassVar[bool] = False
    supports: ClassVar[Mapping[str, Support]] = {"nu": Support(spread=1.0), "scale": POSITIVE}

    def __post_init__(self) -> None:
        above_zero(self, nu=self.nu, scale=self.scale)

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """(nu + m) / (nu + d^2)."""
        return (params[0] + m) / (params[0] + d2)

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """-(nu + m) / 2 log(1 + d^2 / nu)."""
        return -0.5 * (params[0] + m) * np.log1p(d2 / params[0])

    @property
    def params(self) -> tuple[Any, ...]:
        """(nu,)."""
        return (self.nu,)

    def log_normalizer(self, m: int) -> Any:
        """Closed form of the multivariate t."""
        nu = self.nu
        # through the beta function, which does not cancel for large nu
        return betaln(0.5 * nu, 0.5 * m) - gammaln(0.5 * m) + 0.5 * m * np.log(nu * np.pi)

    def parameter_slope(self, name: str, d2: FloatArray, m: Size) -> FloatArray:
        """Derivative by nu."""
        nu, size = np.asarray(self.nu, dtype=float), np.asarray(m, dtype=float)
        constant = 0.5 * (digamma(0.5 * (nu + size)) - digamma(0.5 * nu) - size / nu)
        ratio = d2 / nu
        slope: FloatArray = (
            constant - 0.5 * np.log1p(ratio) + 0.5 * (nu + size) / nu * ratio / (1.0 + ratio)
        )
        return slope

    def unit_covariance_factor(self, m: int) -> Any:
        """Nu / (nu - 2), infinite for nu <= 2."""
        nu = np.asarray(self.nu, dtype=float)
        with np.errstate(divide="ignore"):
            return np.where(nu > 2.0, nu / np.maximum(nu - 2.0, 0.0), np.inf)[()]

    def unit_information_factor(self, m: int) -> float:
        """(nu + m) / (nu + m + 2)."""
        return float((self.nu + m) / (self.nu + m + 2.0))

    def sample_unit(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """Normal vectors over the root of a chi-square of nu degrees of freedom."""
        precision = rng.chisquare(self.nu, n) / self.nu
        return rng.standard_normal((n, m)) / np.sqrt(precision)[:, None]

    def draw_unit_precision(self, rng: np.random.Generator, d2: FloatArray, m: Size) -> FloatArray:
        """Gamma((nu + m) / 2, rate (nu + d^2) / 2)."""
        # standard draws of a full size are faster than draws of an array of scales
        shape = np.asarray(0.5 * (self.nu + m))
        size = np.broadcast_shapes(shape.shape, np.shape(d2))
        return rng.standard_gamma(shape if shape.ndim else float(shape), size) * (
            2.0 / (self.nu + d2)
        )
