"""Sensors: how a report becomes a position, and how a bias and noise move that position.

Sign, everywhere in the package: report = truth + bias + noise. A correction subtracts.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from probreg import geometry
from probreg._linalg import weighted_gram
from probreg.errors import InvalidInputError
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_definite, positive_number

LARGE_ANGLE_SIGMA = 0.25  # rad; no tracking radar is this coarse, but 0.25 deg is common


class Sensor(Protocol):
    """What a registration problem asks of a sensor.

    A report has `len(bias_names)` components; a bias adds to each of them.
    """

    @property
    def name(self) -> str:
        """Prefix of its bias names."""

    @property
    def dim(self) -> int:
        """Number of Cartesian coordinates."""

    @property
    def bias_names(self) -> tuple[str, ...]:
        """Names of the biases, one a report component."""

    @property
    def bias_units(self) -> tuple[str, ...]:
        """Units of the biases, "m" or "rad"."""

    def check(self, reports: FloatArray) -> FloatArray:
        """Return reports, shape (n, q), after checking them."""

    def to_cartesian(self, reports: FloatArray, *, unbiased: bool = True) -> FloatArray:
        """Convert reports (n, q) to positions (n, d) in the common frame."""

    def to_report(self, positions: FloatArray) -> FloatArray:
        """Convert positions (n, d) in the common frame to noise-free reports (n, q)."""

    def sensitivity(self, positions: FloatArray) -> FloatArray:
        """Derivative (n, d, q) of the converted position with respect to the bias."""

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, d, d) of the converted position."""


class _Radar:
    """What radars of two and three dimensions share; fields live in the subclasses."""

    position: tuple[float, ...]
    from_north: bool
    name: str
    dim: ClassVar[int]

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations of the report components, metres and radians."""
        raise AttributeError

    def check(self, reports: FloatArray) -> FloatArray:
        """Check reports (n, q) for shape, non-finite values and degrees passed as radians."""
        reports = finite_array(f"reports of sensor {self.name!r}", reports, (None, self.dim))
        for column, limit, angle in zip((1, 2), (2.0 * np.pi, 0.5 * np.pi), ANGLES, strict=True):
            if column >= self.dim:
                break
            row = np.flatnonzero(np.abs(reports[:, column]) > limit)
            # single rows may be outliers; a wrong unit shows in most of them
            if row.size > 0.25 * len(reports):
                raise InvalidInputError(
                    f"{angle} of sensor {self.name!r} is {reports[row[0], column]:.4g} in row "
                    f"{row[0]}, and beyond {limit:.3g} in {row.size} of {len(reports)} rows: that "
                    "looks like degrees. Pass radians (numpy.deg2rad)."
                )
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


ANGLES = ("azimuth", "elevation")


def _settle(sensor: Any, dim: int, *sigmas: str) -> None:
    """Check a radar's numbers and store them as floats, so that equal sensors compare equal."""
    owner = f"of sensor {sensor.name!r}"
    position = finite_array(f"position {owner}", sensor.position, (dim,))
    object.__setattr__(sensor, "position", tuple(position.tolist()))
    for name in sigmas:
        sigma = positive_number(f"{name} {owner}", getattr(sensor, name))
        object.__setattr__(sensor, name, sigma)
        if name != "sigma_range":
            _question_angle(f"{name} {owner}", sigma)


def _question_angle(name: str, sigma: float) -> None:
    if sigma > np.pi:
        raise InvalidInputError(
            f"{name} is {sigma:.4g} rad, more than half a turn: that looks like degrees. "
            "Pass radians (numpy.deg2rad)."
        )
    if sigma > LARGE_ANGLE_SIGMA:
        warnings.warn(
            f"{name} is {sigma:.4g} rad ({np.rad2deg(sigma):.1f} deg), coarse for a radar; "
            "were degrees meant?",
            stacklevel=5,
        )


@dataclass(frozen=True)
class Radar2D(_Radar):
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
        _settle(self, 2, "sigma_range", "sigma_azimuth")

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations of the report components, metres and radians."""
        return np.array([self.sigma_range, self.sigma_azimuth])


@dataclass(frozen=True)
class Radar3D(_Radar):
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
        _settle(self, 3, "sigma_range", "sigma_azimuth", "sigma_elevation")

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations of the report components, metres and radians."""
        return np.array([self.sigma_range, self.sigma_azimuth, self.sigma_elevation])


@dataclass(frozen=True)
class Tracker2D(_Radar):
    """A radar with a local tracker: biased in (range, azimuth), noise the same in all directions.

    Its reports are the (range, azimuth) of estimated positions, so that the polar biases add
    to them exactly, while the noise is that of the estimate: Cartesian and isotropic.

    Parameters
    ----------
    position : tuple of float
        (x, y) in the common frame, metres.
    sigma : float
        Standard deviation of an estimated position along each axis, metres.
    name : str
        Prefix of its bias names.
    from_north : bool
        Whether azimuth is reported from y (north), clockwise.

    Raises
    ------
    InvalidInputError
        A sigma that is not positive; a position of the wrong length.

    References
    ----------
    Tian and Huang, J. Electronics & Information Technology 40(3), 2018, equations (2), (3).
    """

    position: tuple[float, float]
    sigma: float
    name: str = "tracker"
    from_north: bool = False

    dim: ClassVar[int] = 2
    bias_names: ClassVar[tuple[str, ...]] = ("range", "azimuth")
    bias_units: ClassVar[tuple[str, ...]] = ("m", "rad")

    def __post_init__(self) -> None:
        _settle(self, 2)
        sigma = positive_number(f"sigma of sensor {self.name!r}", self.sigma)
        object.__setattr__(self, "sigma", sigma)

    def to_cartesian(self, reports: FloatArray, *, unbiased: bool = True) -> FloatArray:
        """Convert reports (..., 2) to positions: noise is Cartesian, so no factor is due."""
        return super().to_cartesian(reports, unbiased=False)

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, 2, 2), sigma^2 times the identity."""
        shape = (*np.shape(positions), 2)
        return np.broadcast_to(self.sigma**2 * np.eye(2), shape)


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
