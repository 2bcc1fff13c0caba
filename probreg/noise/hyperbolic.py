"""The hyperbolic law: smoothed least absolute deviation, the law behind RALAD."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.special import kve

from probreg.errors import InvalidInputError
from probreg.noise._checks import above_zero
from probreg.noise._law import Size
from probreg.noise._radial import on_sphere, truncated_chi, truncated_gamma
from probreg.noise._scale_mixture import Mixture, ScaleMixture, log_grid, on_grid
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Hyperbolic(ScaleMixture):
    """Density proportional to exp(-sqrt(d^2 + mu^2)): the Laplace law with a rounded tip.

    RALAD's lambda (Guo et al. 2017, equation 29) is one over this law's weight, and its
    objective (9) is minus the log-likelihood. With `piecewise_at` the weight is 1 wherever
    sqrt(d^2 + mu^2) does not exceed that bound: equation (42).

    Parameters
    ----------
    mu : float or array
        Radius of the rounding, in standard deviations.
    piecewise_at : float, optional
        Bound below which a row is weighted as by least squares.
    scale : float or array
        Factor on the square root of R.
    componentwise : bool
        Treat every whitened component on its own (the L1 norm).
    """

    mu: Any = 1e-3
    piecewise_at: float | None = None
    _: KW_ONLY
    scale: Any = 1.0
    componentwise: bool = False

    kinked: ClassVar[bool] = True

    def __post_init__(self) -> None:
        above_zero(self, mu=self.mu, scale=self.scale)
        if self.piecewise_at is not None:
            above_zero(self, piecewise_at=self.piecewise_at)
            if np.any(np.asarray(self.mu) >= self.piecewise_at):
                raise InvalidInputError(
                    f"Hyperbolic: mu {self.mu!r} must be below piecewise_at {self.piecewise_at!r}."
                )

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """1 / sqrt(d^2 + mu^2), or 1 inside the bound."""
        smooth = np.sqrt(d2 + params[0] * params[0])
        return 1.0 if smooth <= params[1] else 1.0 / smooth

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """-sqrt(d^2 + mu^2), or a parabola inside the bound."""
        smooth = np.sqrt(d2 + params[0] ** 2)
        if params[1] == 0.0:
            return -smooth
        inner = np.minimum(smooth, params[1])
        return -0.5 * (inner**2 - params[0] ** 2) - (smooth - inner)

    @property
    def scale_mixture(self) -> bool:  # type: ignore[override]
        """True without the piecewise bound; with it the kernel has a corner."""
        return self.piecewise_at is None

    @property
    def convex(self) -> bool:  # type: ignore[override]
        """Equation (42) drops the weight at its bound if that is above one, so it is not."""
        return self.piecewise_at is None or self.piecewise_at <= 1.0

    @property
    def params(self) -> tuple[Any, ...]:
        """(mu, bound), with bound 0 for the smooth form."""
        return (self.mu, 0.0 if self.piecewise_at is None else self.piecewise_at)

    @property
    def corners(self) -> tuple[float, ...]:
        """The rounding and, with it, the piecewise bound."""
        edges = {float(self.mu), 1.0, 10.0}
        if self.piecewise_at is not None:
            edges.add(float(np.sqrt(self.piecewise_at**2 - self.mu**2)))
        return tuple(edges)

    def log_normalizer(self, m: int) -> Any:
        """Bessel function of order (m + 1) / 2; the piecewise form by quadrature."""
        if self.piecewise_at is not None:
            return super().log_normalizer(m)
        mu, order = np.asarray(self.mu, dtype=float), 0.5 * (m + 1)
        bessel = np.log(kve(order, mu)) - mu
        return np.log(2.0) + 0.5 * (m - 1) * np.log(2.0 * np.pi) + order * np.log(mu) + bessel

    def unit_covariance_factor(self, m: int) -> Any:
        """Mu K_(m+3)/2(mu) / K_(m+1)/2(mu), which is m + 1 for small mu."""
        if self.piecewise_at is not None:
            return super().unit_covariance_factor(m)
        mu, order = np.asarray(self.mu, dtype=float), 0.5 * (m + 1)
        return (mu * kve(order + 1.0, mu) / kve(order, mu))[()]

    def sample_unit(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """Exact draws: a generalised inverse-Gaussian mixture, or two radial pieces."""
        if self.piecewise_at is not None:
            return on_sphere(rng, self._piecewise_radius(rng, n, m), m)
        from scipy.stats import geninvgauss  # slow to import, needed only here

        mu = float(self.mu)
        variance = mu * geninvgauss.rvs(0.5 * (m + 1), mu, size=n, random_state=rng)
        return np.sqrt(variance)[:, None] * rng.standard_normal((n, m))

    def draw_unit_precision(self, rng: np.random.Generator, d2: FloatArray, m: Size) -> FloatArray:
        """Inverse Gaussian with mean 1 / sqrt(d^2 + mu^2) and shape 1."""
        return rng.wald(1.0 / np.sqrt(d2 + np.asarray(self.mu) ** 2), 1.0)

    def unit_mixture(self, m: int) -> Mixture:
        """A grid over the variance, generalised inverse Gaussian, in the logarithm."""
        if self.piecewise_at is not None:
            raise InvalidInputError("Hyperbolic with piecewise_at is no sum of Gaussians.")
        mu = float(self.mu)
        variance = log_grid(1e-6, 80.0 + 8.0 * mu)
        log_share = 0.5 * (m + 1) * np.log(variance) - 0.5 * (variance + mu**2 / variance)
        return on_grid(log_share, variance)

    def _piecewise_radius(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        bound, mu = float(self.piecewise_at or 0.0), float(self.mu)
        edge = np.sqrt(bound**2 - mu**2)
        inner = self.radial_integral(lambda d2: (d2 <= edge**2).astype(float), m)
        inside = rng.random(n) < inner / np.exp(self.log_normalizer(m))
        radius = np.empty(n)
        radius[inside] = truncated_chi(rng, int(inside.sum()), m, edge)
        todo = np.flatnonzero(~inside)
        # s = sqrt(r^2 + mu^2) has density (s^2 - mu^2)^((m-2)/2) s exp(-s): rejection from a gamma
        top = (1.0 - (mu / bound) ** 2) ** (0.5 * (m - 2)) if m < 2 else 1.0
        while todo.size:
            s = truncated_gamma(rng, todo.size, m, bound)
            keep = rng.random(todo.size) * top < (1.0 - (mu / s) ** 2) ** (0.5 * (m - 2))
            radius[todo[keep]] = np.sqrt(s[keep] ** 2 - mu**2)
            todo = todo[~keep]
        return radius
