"""A radar with a local tracker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors._sensor import settle
from probreg.sensors.radar import PolarSensor
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
        settle(self, 2)
        sigma = positive_number(f"sigma of sensor {self.name!r}", self.sigma)
        object.__setattr__(self, "sigma", sigma)

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 1 km in range and 1 degree in azimuth, the sizes of the source."""
        return np.array([1000.0, np.deg2rad(1.0)])

    def to_cartesian(self, reports: FloatArray, *, unbiased: bool = True) -> FloatArray:
        """Convert reports (..., 2) to positions: noise is Cartesian, so no factor is due."""
        return super().to_cartesian(reports, unbiased=False)

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, 2, 2), sigma^2 times the identity."""
        shape = (*np.shape(positions), 2)
        return np.broadcast_to(self.sigma**2 * np.eye(2), shape)
