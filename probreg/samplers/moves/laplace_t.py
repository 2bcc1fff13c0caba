"""An independent draw from a multivariate t at the mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln

from probreg.posterior.posterior import Posterior
from probreg.typing import FloatArray
from probreg.validation import positive_number


@dataclass(frozen=True)
class LaplaceT:
    """A draw from a multivariate Student-t at the mode, whatever the current state.

    Its scale matrix is the covariance of the Laplace approximation. Its tails are heavier than
    those of the posterior, so it is a global move that is accepted most of the time.

    Parameters
    ----------
    df : float
        Degrees of freedom.
    share : float
        How often the move is chosen, relative to the others.
    """

    df: float = 5.0
    share: float = 0.8

    def __post_init__(self) -> None:
        positive_number("df of LaplaceT", self.df)
        positive_number("share of LaplaceT", self.share)

    def ready(self, posterior: Posterior, gamma: float) -> LaplaceTDensity:
        """Take mode and covariance from the Laplace approximation."""
        laplace = posterior.laplace
        return LaplaceTDensity(laplace.mean, laplace.root / np.sqrt(gamma), self.df)


@dataclass(frozen=True, eq=False)
class LaplaceTDensity:
    """A multivariate Student-t, location (d,), root of its scale matrix (d, d)."""

    mean: FloatArray
    root: FloatArray
    df: float
    target: float | None = None

    def sample(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Draw n states, shape (n, d)."""
        z = rng.standard_normal((n, self.mean.size))
        stretch = np.sqrt(self.df / rng.chisquare(self.df, n))
        return self.mean + stretch[:, None] * (z @ self.root.T)

    def log_density(self, x: FloatArray) -> FloatArray:
        """Normalised log-density of states (..., d), shape (...)."""
        d = self.mean.size
        z = np.linalg.solve(self.root, (x - self.mean)[..., None])[..., 0]
        square = np.einsum("...d,...d->...", z, z)
        constant = gammaln(0.5 * (self.df + d)) - gammaln(0.5 * self.df)
        constant -= 0.5 * d * np.log(self.df * np.pi) + np.log(np.abs(np.diag(self.root))).sum()
        value: FloatArray = constant - 0.5 * (self.df + d) * np.log1p(square / self.df)
        return value

    def propose(
        self, x: FloatArray, step: float, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Draw afresh; the ratio is that of the t at both states."""
        y = self.sample(rng, len(x))
        return y, self.log_density(x) - self.log_density(y)
