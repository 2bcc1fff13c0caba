"""A radar of two dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from probreg.sensors._kind import Kind
from probreg.sensors._sensor import settle
from probreg.sensors.kinds._polar import RADAR_SIGMAS, PolarSensor


@dataclass(frozen=True)
class Radar2D(PolarSensor):
    """A radar that reports (range, azimuth).

    Parameters
    ----------
    position : tuple of float
        (x, y), or (x, y, z) where its height is known, in the common frame, metres.
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

    position: tuple[float, ...]
    sigma_range: float
    sigma_azimuth: float
    name: str = "radar"
    from_north: bool = False

    dim: ClassVar[int] = 2
    bias_names: ClassVar[tuple[str, ...]] = ("range", "azimuth")
    bias_units: ClassVar[tuple[str, ...]] = ("m", "rad")
    kind: ClassVar[Kind] = Kind("radar2d", ("range_m", "azimuth_deg"), RADAR_SIGMAS, coordinates=2)

    def __post_init__(self) -> None:
        settle(self, 2, "sigma_range", "sigma_azimuth")
