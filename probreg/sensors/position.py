"""A sensor that reports Cartesian positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_definite


@dataclass(frozen=True)
class PositionSensor:
    """A sensor that reports Cartesian positions in the common frame, with a position offset.

    Parameters
    ----------
    noise_covariance : tuple of tuple of float
        Covariance of a report, (d, d) with d = 2 or 3, square metres.
    name : str
        Prefix of its bias names, "name.x", "name.y" (and "name.z").

    Raises
    ------
    InvalidInputError
        A covariance that is not positive definite or not 2 x 2 or 3 x 3.
    """

    noise_covariance: tuple[tuple[float, ...], ...]
    name: str = "position"

    def __post_init__(self) -> None:
        label = f"noise_covariance of sensor {self.name!r}"
        covariance = finite_array(label, self.noise_covariance, (None, None))
        if covariance.shape not in ((2, 2), (3, 3)):
            raise InvalidInputError(f"{label} must be 2 x 2 or 3 x 3, not {covariance.shape}.")
        positive_definite(label, covariance[None])
        plain = tuple(tuple(row) for row in covariance.tolist())
        object.__setattr__(self, "noise_covariance", plain)

    @property
    def dim(self) -> int:
        """Number of Cartesian coordinates."""
        return len(self.noise_covariance)

    @property
    def bias_names(self) -> tuple[str, ...]:
        """Names of the offsets."""
        return ("x", "y", "z")[: self.dim]

    @property
    def bias_units(self) -> tuple[str, ...]:
        """Units of the offsets."""
        return ("m",) * self.dim

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 100 m along each axis."""
        return np.full(self.dim, 100.0)

    def check(self, reports: FloatArray) -> FloatArray:
        """Check reports (n, d) for shape and non-finite values."""
        return finite_array(f"reports of sensor {self.name!r}", reports, (None, self.dim))

    def to_cartesian(self, reports: FloatArray, *, unbiased: bool = True) -> FloatArray:
        """Return the reports: they are positions, and linear, so `unbiased` changes nothing."""
        return np.asarray(reports, dtype=float)

    def to_report(self, positions: FloatArray) -> FloatArray:
        """Return the positions."""
        return np.asarray(positions, dtype=float)

    def sensitivity(self, positions: FloatArray) -> FloatArray:
        """Derivative (n, d, d) of position by offset: the identity."""
        return np.broadcast_to(np.eye(self.dim), (*np.shape(positions), self.dim))

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, d, d): the same for every report."""
        shape = (*np.shape(positions), self.dim)
        return np.broadcast_to(np.asarray(self.noise_covariance, dtype=float), shape)

    def sample_noise(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Draw n Gaussian report errors, shape (n, d)."""
        root = np.linalg.cholesky(np.asarray(self.noise_covariance, dtype=float))
        return rng.standard_normal((n, self.dim)) @ root.T
