"""What sensors that report range and angles share."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.numerics.linalg import weighted_gram
from probreg.sensors import geometry
from probreg.sensors._kind import Kind
from probreg.sensors._sensor import Equations, observe_position, relative
from probreg.sensors.axes import PolarAxes, Site, polar_axes
from probreg.typing import FloatArray
from probreg.validation import finite_array, refuse_degrees

ANGLES = ("azimuth", "elevation")
RADAR_SIGMAS = {"sigma_range_m": "sigma_range", "sigma_azimuth_deg": "sigma_azimuth"}


class PolarSensor:
    """What radars of two and three dimensions share; fields live in the subclasses."""

    position: tuple[float, ...]
    from_north: bool
    name: str
    dim: ClassVar[int]
    bias_names: ClassVar[tuple[str, ...]]
    bias_units: ClassVar[tuple[str, ...]]
    kind: ClassVar[Kind]

    azimuth_column: ClassVar[int | None] = 1
    gives_position: ClassVar[bool] = True
    cartesian: ClassVar[bool] = False

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations of the report components, metres and radians."""
        return np.array([getattr(self, parameter) for parameter in self.kind.sigmas.values()])

    @property
    def principal(self) -> tuple[FloatArray, None]:
        """Accuracies of the components, whose errors are independent."""
        return self.sigmas, None

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

    @property
    def _place(self) -> FloatArray:
        """Its place in a frame of `dim` coordinates."""
        return np.asarray(self.position[: self.dim])

    def _local(self, positions: FloatArray) -> FloatArray:
        local = positions - self._place
        above = np.flatnonzero(np.hypot(local[..., 0], local[..., 1]) == 0.0)
        if above.size:
            raise InvalidInputError(
                f"the position in row {above[0]} lies on the vertical of sensor {self.name!r}: its "
                "azimuth is undefined. Remove that row or move the sensor."
            )
        return local

    def to_cartesian(
        self, reports: FloatArray, own: FloatArray | None = None, *, unbiased: bool = True
    ) -> FloatArray:
        """Convert reports (n, q) to positions (n, d), by default with the unbiased factors."""
        local = geometry.polar_to_cartesian(self._internal(reports))
        if unbiased:
            local = local * geometry.unbiased_factors(*self.sigmas[1:])
        where = self._place + local
        return where if own is None else where + own

    def to_report(self, positions: FloatArray, own: FloatArray | None = None) -> FloatArray:
        """Convert positions (n, d) to noise-free reports (n, q)."""
        local = self._local(relative(positions, own))
        return self._internal(geometry.cartesian_to_polar(local))

    def axes(self, site: Site) -> PolarAxes:
        """Its own level, north and refraction, wherever it stands."""
        return polar_axes(self.position, self.bias_names, self.from_north, site)

    def observe(
        self, reports: FloatArray, at: FloatArray | None = None, own: FloatArray | None = None
    ) -> Equations:
        """Equations of the converted reports, linearised about targets at (n, d)."""
        return observe_position(self, reports, at, own)

    def sensitivity(self, positions: FloatArray) -> FloatArray:
        """Derivative (n, d, q) of position by report: Guo et al. (2017), equation (4)."""
        jacobian = geometry.polar_jacobian(self._local(positions))
        if self.from_north:
            jacobian[..., 1] *= -1.0
        return jacobian

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, d, d) of a converted report, first order in the report noise."""
        return weighted_gram(np.ascontiguousarray(self.sensitivity(positions)), self.sigmas**2)

    def report_sd(self, reports: FloatArray) -> FloatArray:
        """Standard deviations (n, q), the same for every report."""
        return np.broadcast_to(self.sigmas, np.shape(reports))

    def sample_noise(
        self, rng: np.random.Generator, n: int, at: FloatArray | None = None
    ) -> FloatArray:
        """Draw n Gaussian report errors, shape (n, q), wherever the targets are."""
        return rng.standard_normal((n, self.dim)) * self.sigmas
