"""The Student-t law: robust, redescending, a Gaussian scale mixture."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import betaln, digamma, gammaln

from probreg.noise._checks import above_zero
from probreg.noise._law import Size
from probreg.noise._scale_mixture import (
    Mixture,
    MixtureCounts,
    ScaleMixture,
    log_grid,
    on_grid,
)
from probreg.noise._support import POSITIVE, Support
from probreg.typing import FloatArray

NU_BOUNDS = (float(np.log(0.5)), float(np.log(100.0)))  # where it is estimated


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

    def unit_mixture(self, m: int) -> Mixture:
        """A grid over the precision, Gamma(nu / 2, rate nu / 2), in the logarithm."""
        nu = float(self.nu)
        precision = log_grid(1e-6, 8.0 + 12.0 / nu, min(0.5, 1.5 / np.sqrt(nu)))
        return on_grid(self._log_share(precision, nu), 1.0 / precision)

    def refitted(
        self, counts: MixtureCounts, m: int, unknown: Collection[str], about: StudentT
    ) -> StudentT:
        """Scale, and nu with the prior Gamma(2, 0.1) of Juarez and Steel (2010)."""
        law = super().refitted(counts, m, unknown, about)
        if "nu" not in unknown:
            return law
        found = minimize_scalar(
            lambda log_nu: -self._log_posterior(np.atleast_1d(log_nu), counts, m)[0],
            bounds=NU_BOUNDS,
            method="bounded",
        )
        return replace(law, nu=float(np.exp(found.x)))

    def draw_parameters(
        self,
        rng: np.random.Generator,
        counts: MixtureCounts,
        m: int,
        unknown: Collection[str],
        about: StudentT,
    ) -> StudentT:
        """Draw scale and nu given the precision of each row, nu on a fine grid."""
        law = super().draw_parameters(rng, counts, m, unknown, about)
        if "nu" not in unknown:
            return law
        log_nu = np.linspace(*NU_BOUNDS, 400)
        log_p = self._log_posterior(log_nu, counts, m)
        p = np.cumsum(np.exp(log_p - log_p.max()))
        # anywhere within a cell of the grid
        cell = np.searchsorted(p, rng.random() * p[-1])
        step = log_nu[1] - log_nu[0]
        return replace(law, nu=float(np.exp(log_nu[cell] + step * (rng.random() - 0.5))))

    def _log_posterior(self, log_nu: FloatArray, counts: MixtureCounts, m: int) -> FloatArray:
        """Of the logarithms of nu (k,) given counts of precisions."""
        precision = 1.0 / self.unit_mixture(m).variance
        nu = np.exp(log_nu)
        half, rows = 0.5 * nu, counts.rows.sum()
        said = float(counts.rows @ (np.log(precision) - precision))
        fit = rows * (half * np.log(half) - gammaln(half)) + half * said
        return np.asarray(fit + 2.0 * log_nu - 0.1 * nu)

    @staticmethod
    def _log_share(precision: FloatArray, nu: float) -> FloatArray:
        half = 0.5 * nu
        log_density = half * np.log(half) - gammaln(half) + half * (np.log(precision) - precision)
        return np.asarray(log_density)
