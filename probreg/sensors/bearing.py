"""A passive sensor that reports bearings only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors import geometry
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

    def __post_init__(self) -> None:
        label = f"sigma_bearing of sensor {self.name!r}"
        object.__setattr__(self, "sigma_bearing", angle_sigma(label, self.sigma_bearing))

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 1 degree."""
        return np.array([np.deg2rad(1.0)])

    def check(self, reports: FloatArray) -> FloatArray:
        """Check bearings (n,) or (n, 1): shape, non-finite values, degrees passed as radians."""
        label = f"bearing of sensor {self.name!r}"
        reports = finite_array(label, reports, (None, 1)[: max(np.ndim(reports), 1)])
        refuse_degrees(label, reports, 2.0 * np.pi)
        return reports

    def to_report(self, positions: FloatArray, own_position: FloatArray) -> FloatArray:
        """Convert positions (n, 2), seen from own positions (n, 2), to noise-free bearings (n,)."""
        local = np.asarray(positions, dtype=float) - np.asarray(own_position, dtype=float)
        here = np.flatnonzero((local == 0.0).all(axis=-1))
        if here.size:
            raise InvalidInputError(
                f"the position in row {here[0]} is that of sensor {self.name!r} itself: its "
                "bearing is undefined."
            )
        azimuth = np.arctan2(local[..., 1], local[..., 0])
        return geometry.azimuth_from_north(azimuth) if self.from_north else azimuth

    def sample_noise(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Draw n Gaussian bearing errors, shape (n,)."""
        return self.sigma_bearing * rng.standard_normal(n)
