"""Priors on the unknowns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import NoiseLaw
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_definite, positive_number


class Unknowns(Protocol):
    """What a prior asks of a problem: its unknowns, where they start, and how large they are."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""

    @property
    def start(self) -> FloatArray:
        """Where the problem is linearised first, shape (p,)."""

    @property
    def prior_sd(self) -> FloatArray:
        """Standard deviations of the default prior about `start`, shape (p,)."""


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

    @classmethod
    def default(cls, problem: Unknowns) -> GaussianPrior:
        """Independent prior with the scales of the problem's sensors, about its start."""
        return cls.from_sd(problem.prior_sd, problem.start)

    @classmethod
    def by_name(cls, problem: Unknowns, given: Mapping[str, tuple[float, float]]) -> GaussianPrior:
        """Independent prior with (mean, sd) of named unknowns, the others by default.

        Raises
        ------
        InvalidInputError
            A name that the problem has not.
        """
        mean, sd = problem.start.copy(), problem.prior_sd.copy()
        for name, (centre, spread) in given.items():
            if name not in problem.names:
                raise InvalidInputError(
                    f"the problem has no unknown {name!r}; it has {', '.join(problem.names)}."
                )
            k = problem.names.index(name)
            mean[k], sd[k] = centre, spread
        return cls.from_sd(sd, mean)

    @cached_property
    def precision(self) -> FloatArray:
        """Inverse covariance, shape (p, p)."""
        return self.root_precision.T @ self.root_precision

    @cached_property
    def root_precision(self) -> FloatArray:
        """Matrix W with W'W the prior precision: rows to append to a whitened problem."""
        return np.linalg.inv(np.linalg.cholesky(self.covariance))

    def log_density(self, theta: FloatArray) -> FloatArray:
        """Normalised log-density of theta, shape (..., p) to (...)."""
        v = (theta - self.mean) @ self.root_precision.T
        return -0.5 * np.einsum("...p,...p->...", v, v) - 0.5 * self._log_det

    @cached_property
    def _log_det(self) -> float:
        return float(np.linalg.slogdet(2.0 * np.pi * self.covariance)[1])

    def sample(self, rng: np.random.Generator) -> FloatArray:
        """Draw one parameter vector, shape (p,)."""
        return self.mean + np.linalg.cholesky(self.covariance) @ rng.standard_normal(self.mean.size)

    def check(self, names: tuple[str, ...]) -> None:
        """Raise unless the prior has one entry a parameter name."""
        if self.mean.size != len(names):
            raise InvalidInputError(
                f"the prior has {self.mean.size} entries, the problem {len(names)} unknowns: "
                f"{', '.join(names)}."
            )


@dataclass(frozen=True)
class NoiseParameter:
    """An unknown parameter of the noise law, with its prior.

    The prior is Gaussian in the free coordinate: log-normal for a scale or nu, logit-normal
    for a share, log-normal above one for the outliers' scale.

    Parameters
    ----------
    name : str
        Field of the law: "nu", "rate", "scale", "core_scale".
    median : float
        Prior median of the parameter itself.
    spread : float
        Prior standard deviation of the free coordinate: 0.5 is about 50 % either way.

    Raises
    ------
    InvalidInputError
        A spread that is not above zero.
    """

    name: str
    median: float
    spread: float = 0.5

    def __post_init__(self) -> None:
        positive_number(f"spread of noise parameter {self.name!r}", self.spread)

    def check(self, noise: NoiseLaw) -> None:
        """Raise unless the law has this parameter and the median is a value it may take."""
        law = type(noise).__name__
        if self.name not in noise.supports:
            raise InvalidInputError(
                f"{law} has no parameter {self.name!r} that can be unknown; it has "
                f"{', '.join(noise.supports)}."
            )
        if not noise.supports[self.name].holds(self.median):
            raise InvalidInputError(
                f"the median {self.median!r} of {law}'s {self.name!r} is not a value it may take."
            )

    def free_median(self, noise: NoiseLaw) -> float:
        """The median in the free coordinate."""
        return float(noise.supports[self.name].free(self.median))

    def log_density(self, free: FloatArray, noise: NoiseLaw) -> FloatArray:
        """Normalised log-density in the free coordinate."""
        z = (free - self.free_median(noise)) / self.spread
        return -0.5 * z**2 - np.log(self.spread) - 0.5 * np.log(2.0 * np.pi)

    def log_density_slope(self, free: FloatArray, noise: NoiseLaw) -> FloatArray:
        """Its derivative."""
        return -(free - self.free_median(noise)) / self.spread**2

    def sample(self, rng: np.random.Generator, noise: NoiseLaw) -> float:
        """Draw the parameter itself."""
        free = self.free_median(noise) + self.spread * rng.standard_normal()
        return float(noise.supports[self.name].natural(free))
