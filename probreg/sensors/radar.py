"""Radars of two and three dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.numerics.linalg import weighted_gram
from probreg.sensors import geometry
from probreg.sensors._sensor import settle
from probreg.typing import FloatArray
from probreg.validation import finite_array, refuse_degrees

ANGLES = ("azimuth", "elevation")


class PolarSensor:
    """What radars of two and three dimensions share; fields live in the subclasses."""

    position: tuple[float, ...]
    from_north: bool
    name: str
    dim: ClassVar[int]

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations of the report components, metres and radians."""
        raise AttributeError

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 100 m in range and 1 degree in the angles, as field radars are found."""
        return np.array([100.0, *np.full(self.dim - 1, np.deg2rad(1.0))])

    def check(self, reports: FloatArray) -> FloatArray:
        """Check reports (n, q) for shape, non-finite values and degrees passed as radians."""
        reports = finite_array(f"reports of sensor {self.name!r}", reports, (None, self.dim))
        for column, limit, angle in zip((1, 2), (2.0 * np.pi, 0.5 * np.pi), ANGLES, strict=True):
            if column >= self.dim:
                break
            refuse_degrees(f"{angle} of sensor {self.name!r}", reports[:, column], limit)
        return reports

    def _internal(self, reports: FloatArray) -> FloatArray:
        if not self.from_north:
            return reports
        polar = reports.copy()
        polar[..., 1] = geometry.azimuth_from_north(reports[..., 1])
        return polar

    def _local(self, positions: FloatArray) -> FloatArray:
        local = positions - np.asarray(self.position)
        above = np.flatnonzero(np.hypot(local[..., 0], local[..., 1]) == 0.0)
        if above.size:
            raise InvalidInputError(
                f"the position in row {above[0]} lies on the vertical of sensor {self.name!r}: its "
                "azimuth is undefined. Remove that row or move the sensor."
            )
        return local

    def to_cartesian(self, reports: FloatArray, *, unbiased: bool = True) -> FloatArray:
        """Convert reports (n, q) to positions (n, d), by default with the unbiased factors."""
        local = geometry.polar_to_cartesian(self._internal(reports))
        if unbiased:
            local = local * geometry.unbiased_factors(*self.sigmas[1:])
        return np.asarray(self.position) + local

    def to_report(self, positions: FloatArray) -> FloatArray:
        """Convert positions (n, d) to noise-free reports (n, q)."""
        return self._internal(geometry.cartesian_to_polar(self._local(positions)))

    def sensitivity(self, positions: FloatArray) -> FloatArray:
        """Derivative (n, d, q) of position by report: Guo et al. (2017), equation (4)."""
        jacobian = geometry.polar_jacobian(self._local(positions))
        if self.from_north:
            jacobian[..., 1] *= -1.0
        return jacobian

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, d, d) of a converted report, first order in the report noise."""
        return weighted_gram(np.ascontiguousarray(self.sensitivity(positions)), self.sigmas**2)

    def sample_noise(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Draw n Gaussian report errors, shape (n, q)."""
        return rng.standard_normal((n, self.dim)) * self.sigmas


@dataclass(frozen=True)
class Radar2D(PolarSensor):
    """A radar that reports (range, azimuth).

    Parameters
    ----------
    position : tuple of float
        (x, y) in the common frame, metres.
    sigma_range : float
        Standard deviation of range, metres.
    sigma_azimuth : float
        Standard deviation of azimuth, radians.
    name : str
        Prefix of its bias names, "name.range" and "name.azimuth".
    from_north : bool
        Whether it reports azimuth from y (north), clockwise, instead of from x,
        counter-clockwise. Its azimuth bias is then counted clockwise too.

    Raises
    ------
    InvalidInputError
        Sigmas that are not positive or look like degrees; a position of the wrong length.
    """

    position: tuple[float, float]
    sigma_range: float
    sigma_azimuth: float
    name: str = "radar"
    from_north: bool = False

    dim: ClassVar[int] = 2
    bias_names: ClassVar[tuple[str, ...]] = ("range", "azimuth")
    bias_units: ClassVar[tuple[str, ...]] = ("m", "rad")

    def __post_init__(self) -> None:
        settle(self, 2, "sigma_range", "sigma_azimuth")

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations of the report components, metres and radians."""
        return np.array([self.sigma_range, self.sigma_azimuth])


@dataclass(frozen=True)
class Radar3D(PolarSensor):
    """A radar that reports (range, azimuth, elevation); parameters as for `Radar2D`.

    Parameters
    ----------
    position : tuple of float
        (x, y, z) in the common frame, metres.
    sigma_range : float
        Standard deviation of range, metres.
    sigma_azimuth, sigma_elevation : float
        Standard deviations of the angles, radians.
    name : str
        Prefix of its bias names.
    from_north : bool
        Whether azimuth is reported from y (north), clockwise.

    Raises
    ------
    InvalidInputError
        Sigmas that are not positive or look like degrees; a position of the wrong length.
    """

    position: tuple[float, float, float]
    sigma_range: float
    sigma_azimuth: float
    sigma_elevation: float
    name: str = "radar"
    from_north: bool = False

    dim: ClassVar[int] = 3
    bias_names: ClassVar[tuple[str, ...]] = ("range", "azimuth", "elevation")
    bias_units: ClassVar[tuple[str, ...]] = ("m", "rad", "rad")

    def __post_init__(self) -> None:
        settle(self, 3, "sigma_range", "sigma_azimuth", "sigma_elevation")

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations of the report components, metres and radians."""
        return np.array([self.sigma_range, self.sigma_azimuth, self.sigma_elevation])
