"""A passive sensor that reports bearings only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors import geometry
from probreg.sensors._kind import Kind
from probreg.sensors._sensor import Equations
from probreg.sensors.axes import PolarAxes, Site
from probreg.sensors.azimuths import counter_clockwise, sense
from probreg.typing import FloatArray
from probreg.validation import angle_sigma, finite_array, refuse_degrees


@dataclass(frozen=True)
class BearingSensor:
    """A passive sensor on a moving platform: it reports the bearing of an emitter, no range.

    Parameters
    ----------
    sigma_bearing : float
        Standard deviation of a bearing, radians.
    name : str
        Prefix of its bias name, "name.bearing".
    from_north : bool
        Whether it reports from y (north), clockwise, instead of from x, counter-clockwise.
        Its bias is then counted clockwise too.

    Raises
    ------
    InvalidInputError
        A sigma that is not positive or looks like degrees.
    """

    sigma_bearing: float
    name: str = "sensor"
    from_north: bool = False

    dim: ClassVar[int] = 2
    bias_names: ClassVar[tuple[str, ...]] = ("bearing",)
    bias_units: ClassVar[tuple[str, ...]] = ("rad",)
    kind: ClassVar[Kind] = Kind("bearing", ("azimuth_deg",), {"sigma_azimuth_deg": "sigma_bearing"})
    position: ClassVar[None] = None
    azimuth_column: ClassVar[int | None] = 0
    gives_position: ClassVar[bool] = False
    cartesian: ClassVar[bool] = False

    def __post_init__(self) -> None:
        label = f"sigma_bearing of sensor {self.name!r}"
        object.__setattr__(self, "sigma_bearing", angle_sigma(label, self.sigma_bearing))

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviation of a bearing (1,), radians."""
        return np.array([self.sigma_bearing])

    @property
    def principal(self) -> tuple[FloatArray, None]:
        """Accuracies of the components, whose errors are independent."""
        return self.sigmas, None

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 1 degree."""
        return np.array([np.deg2rad(1.0)])

    def check(self, reports: FloatArray) -> FloatArray:
        """Check bearings (n, 1): shape, non-finite values, degrees passed as radians."""
        label = f"bearing of sensor {self.name!r}"
        reports = finite_array(label, reports, (None, 1))
        refuse_degrees(label, reports[:, 0], 2.0 * np.pi)
        return reports

    def to_cartesian(
        self, reports: FloatArray, own: FloatArray | None = None, *, unbiased: bool = True
    ) -> FloatArray:
        """NaN (n, 2): a bearing alone places no target."""
        return np.full((len(reports), self.dim), np.nan)

    def to_report(self, positions: FloatArray, own: FloatArray | None = None) -> FloatArray:
        """Convert positions (n, 2), seen from own positions (n, 2), to bearings (n, 1).

        By default they are seen from the origin of the common frame.
        """
        local = np.asarray(positions, dtype=float)
        local = local if own is None else local - np.asarray(own, dtype=float)
        here = np.flatnonzero((local == 0.0).all(axis=-1))
        if here.size:
            raise InvalidInputError(
                f"the position in row {here[0]} is that of sensor {self.name!r} itself: its "
                "bearing is undefined."
            )
        azimuth = np.arctan2(local[..., 1:], local[..., :1])
        return geometry.azimuth_from_north(azimuth) if self.from_north else azimuth

    def axes(self, site: Site) -> PolarAxes:
        """Its azimuth, from the platform that carries it."""
        return PolarAxes(np.zeros(site.dim), ("azimuth",), None, self.from_north)

    def observe(
        self, reports: FloatArray, at: FloatArray | None = None, own: FloatArray | None = None
    ) -> Equations:
        """One equation a report, along the line across the line of sight; none without `at`."""
        n, d = len(reports), self.dim
        e, G, C, D = np.zeros((n, d)), np.zeros((n, d, d)), np.zeros((n, d, d)), np.zeros((n, d, 1))
        if at is None:
            return Equations(e, G, C, D)
        local = at if own is None else at - own
        azimuth, by_x, by_y = geometry.azimuth_and_gradient(*local.T)
        G[:, 0, 0], G[:, 0, 1] = by_x, by_y
        left = geometry.wrap_angle(counter_clockwise(self, reports[:, 0]) - azimuth)
        e[:, 0] = left + np.einsum("nd,nd->n", G[:, 0], at)
        C[:, 0, 0] = self.sigma_bearing**2
        D[:, 0, 0] = sense(self)
        return Equations(e, G, C, D)

    def report_sd(self, reports: FloatArray) -> FloatArray:
        """Standard deviations (n, 1), the same for every report."""
        return np.broadcast_to(self.sigmas, np.shape(reports))

    def sample_noise(
        self, rng: np.random.Generator, n: int, at: FloatArray | None = None
    ) -> FloatArray:
        """Draw n Gaussian bearing errors, shape (n, 1), wherever the emitter is."""
        return self.sigma_bearing * rng.standard_normal((n, 1))
