"""A sensor that reports Cartesian positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors._kind import Kind
from probreg.sensors._sensor import Equations, observe_position, relative
from probreg.sensors.axes import GeodeticAxes, PositionAxes, Site
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

    kind: ClassVar[Kind] = Kind(
        "position",
        ("east_m", "north_m", "up_m"),
        {"sigma_m": "sigma"},
        maker="independent",
        per_axis=True,
    )
    position: ClassVar[None] = None
    azimuth_column: ClassVar[int | None] = None
    from_north: ClassVar[bool] = False
    gives_position: ClassVar[bool] = True
    cartesian: ClassVar[bool] = True

    @classmethod
    def independent(cls, sigma: Sequence[float], name: str = "position") -> Self:
        """A sensor whose axes have errors of their own, of standard deviations (d,), metres."""
        variances = np.diag(np.asarray(sigma, dtype=float) ** 2)
        return cls(tuple(tuple(row) for row in variances.tolist()), name)

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
    def sigmas(self) -> FloatArray:
        """Standard deviations along the axes, metres."""
        return np.sqrt(np.diag(np.asarray(self.noise_covariance)))

    @property
    def sigma(self) -> list[float]:
        """The same, of a sensor that they describe in full.

        Raises
        ------
        InvalidInputError
            Errors that correlate.
        """
        covariance = np.asarray(self.noise_covariance)
        if not np.array_equal(covariance, np.diag(np.diag(covariance))):
            raise InvalidInputError(f"errors of sensor {self.name!r} must not correlate.")
        return self.sigmas.tolist()

    @property
    def principal(self) -> tuple[FloatArray, FloatArray | None]:
        """Accuracies along the principal axes of the errors, and the rotation into these."""
        C = np.asarray(self.noise_covariance)
        if np.array_equal(C, np.diag(np.diag(C))):
            return self.sigmas, None
        variance, vectors = np.linalg.eigh(C)
        return np.sqrt(variance), vectors.T

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 100 m along each axis."""
        return np.full(self.dim, 100.0)

    def check(self, reports: FloatArray) -> FloatArray:
        """Check reports (n, d) for shape and non-finite values; a height may be missing."""
        label = f"reports of sensor {self.name!r}"
        given = np.asarray(reports, dtype=float)
        if given.ndim == 2 and given.shape[1] == self.dim == 3:
            missing = np.isnan(given[:, 2:])
            finite_array(label, np.where(missing, 0.0, given[:, 2:]), (None, 1))
            finite_array(label, given[:, :2], (None, 2))
            return given
        return finite_array(label, reports, (None, self.dim))

    def to_cartesian(
        self, reports: FloatArray, own: FloatArray | None = None, *, unbiased: bool = True
    ) -> FloatArray:
        """Return the reports: they are positions, and linear, so `unbiased` changes nothing."""
        reports = np.asarray(reports, dtype=float)
        return reports if own is None else reports + own

    def to_report(self, positions: FloatArray, own: FloatArray | None = None) -> FloatArray:
        """Return the positions, as seen from the platform."""
        return relative(np.asarray(positions, dtype=float), own)

    def axes(self, site: Site) -> PositionAxes | GeodeticAxes:
        """The coordinates of the common frame, or latitude, longitude and height."""
        if not site.geodetic:
            return PositionAxes(site.dim, self.dim)
        if site.frame is None:
            raise InvalidInputError(
                f"sensor {self.name!r} reports in latitude and longitude: the frame needs an "
                "origin."
            )
        return GeodeticAxes(site.frame.origin, site.dim, self.dim)

    def observe(
        self, reports: FloatArray, at: FloatArray | None = None, own: FloatArray | None = None
    ) -> Equations:
        """Equations of the reports, linear everywhere."""
        return observe_position(self, reports, at, own)

    def sensitivity(self, positions: FloatArray) -> FloatArray:
        """Derivative (n, d, d) of position by offset: the identity."""
        return np.broadcast_to(np.eye(self.dim), (*np.shape(positions), self.dim))

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, d, d): the same for every report."""
        shape = (*np.shape(positions), self.dim)
        return np.broadcast_to(np.asarray(self.noise_covariance, dtype=float), shape)

    def report_sd(self, reports: FloatArray) -> FloatArray:
        """Standard deviations (n, d), the same for every report."""
        return np.broadcast_to(self.sigmas, np.shape(reports))

    def sample_noise(
        self, rng: np.random.Generator, n: int, at: FloatArray | None = None
    ) -> FloatArray:
        """Draw n Gaussian report errors, shape (n, d), wherever the targets are."""
        root = np.linalg.cholesky(np.asarray(self.noise_covariance, dtype=float))
        return rng.standard_normal((n, self.dim)) @ root.T
