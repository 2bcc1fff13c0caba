"""A radar with a local tracker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors import geometry
from probreg.sensors._kind import Kind
from probreg.sensors._sensor import settle
from probreg.sensors.kinds._polar import PolarSensor
from probreg.typing import FloatArray
from probreg.validation import positive_number


@dataclass(frozen=True)
class Tracker2D(PolarSensor):
    """A radar with a local tracker: biased in (range, azimuth), noise the same in all directions.

    Its reports are the (range, azimuth) of estimated positions, so that the polar biases add
    to them exactly, while the noise is that of the estimate: Cartesian and isotropic.

    Parameters
    ----------
    position : tuple of float
        (x, y), or (x, y, z) where its height is known, in the common frame, metres.
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

    position: tuple[float, ...]
    sigma: float
    name: str = "tracker"
    from_north: bool = False

    dim: ClassVar[int] = 2
    bias_names: ClassVar[tuple[str, ...]] = ("range", "azimuth")
    bias_units: ClassVar[tuple[str, ...]] = ("m", "rad")
    kind: ClassVar[Kind] = Kind(
        "tracker2d", ("range_m", "azimuth_deg"), {"sigma_m": "sigma"}, coordinates=2
    )

    def __post_init__(self) -> None:
        settle(self, 2)
        sigma = positive_number(f"sigma of sensor {self.name!r}", self.sigma)
        object.__setattr__(self, "sigma", sigma)

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations along and across the line of sight, both metres."""
        return np.full(2, self.sigma)

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 1 km in range and 1 degree in azimuth, the sizes of the source."""
        return np.array([1000.0, np.deg2rad(1.0)])

    def to_cartesian(
        self, reports: FloatArray, own: FloatArray | None = None, *, unbiased: bool = True
    ) -> FloatArray:
        """Convert reports (..., 2) to positions: noise is Cartesian, so no factor is due."""
        return super().to_cartesian(reports, own, unbiased=False)

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, 2, 2), sigma^2 times the identity."""
        shape = (*np.shape(positions), 2)
        return np.broadcast_to(self.sigma**2 * np.eye(2), shape)

    def report_sd(self, reports: FloatArray) -> FloatArray:
        """Standard deviations (n, 2): that of the azimuth falls with the range, from a radian."""
        far = np.maximum(np.asarray(reports, dtype=float)[:, :1], self.sigma)
        return np.concatenate([np.full(far.shape, self.sigma), self.sigma / far], axis=1)

    def sample_noise(
        self, rng: np.random.Generator, n: int, at: FloatArray | None = None
    ) -> FloatArray:
        """Draw n report errors, shape (n, 2), of Gaussian errors of positions.

        Raises
        ------
        InvalidInputError
            Without `at`: the error of an azimuth depends on how far the target is.
        """
        if at is None:
            raise InvalidInputError(
                f"the errors of sensor {self.name!r} depend on where its targets are; pass `at`."
            )
        moved = self.to_report(at + self.sigma * rng.standard_normal((n, 2)))
        error = moved - self.to_report(at)
        error[:, 1] = geometry.wrap_angle(error[:, 1])
        return error
