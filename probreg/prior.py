"""Priors on the unknowns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_definite


@dataclass(frozen=True, eq=False)
class GaussianPrior:
    """A Gaussian prior on the parameter vector.

    Parameters
    ----------
    mean : ndarray, shape (p,)
        Prior mean, in the problem's units.
    covariance : ndarray, shape (p, p)
        Prior covariance.

    Raises
    ------
    InvalidInputError
        Non-finite values, a wrong shape, a covariance that is not positive definite.
    """

    mean: FloatArray
    covariance: FloatArray

    def __post_init__(self) -> None:
        mean = finite_array("prior mean", self.mean, (None,))
        covariance = finite_array("prior covariance", self.covariance, (mean.size, mean.size))
        positive_definite("prior covariance", covariance[None])
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "covariance", covariance)

    @classmethod
    def from_sd(cls, sd: FloatArray, mean: FloatArray | float = 0.0) -> GaussianPrior:
        """Independent prior from standard deviations, shape (p,)."""
        sd = finite_array("prior sd", sd, (None,))
        if np.any(sd <= 0.0):
            raise InvalidInputError(f"prior sd is {sd}; every entry must be above zero.")
        mean = np.asarray(mean, dtype=float)
        if mean.shape not in ((), sd.shape):
            raise InvalidInputError(f"prior mean has shape {mean.shape}, prior sd {sd.shape}.")
        return cls(np.broadcast_to(mean, sd.shape), np.diag(sd**2))

    @property
    def root_precision(self) -> FloatArray:
        """Matrix W with W'W the prior precision: rows to append to a whitened problem."""
        return np.linalg.inv(np.linalg.cholesky(self.covariance))

    def log_density(self, theta: FloatArray) -> FloatArray:
        """Normalised log-density of theta, shape (..., p) to (...)."""
        v = (theta - self.mean) @ self.root_precision.T
        log_det = np.linalg.slogdet(2.0 * np.pi * self.covariance)[1]
        return -0.5 * np.einsum("...p,...p->...", v, v) - 0.5 * log_det

    def check(self, names: tuple[str, ...]) -> None:
        """Raise unless the prior has one entry a parameter name."""
        if self.mean.size != len(names):
            raise InvalidInputError(
                f"the prior has {self.mean.size} entries, the problem {len(names)} unknowns: "
                f"{', '.join(names)}."
            )
