"""A radar of three dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from probreg.sensors._kind import Kind
from probreg.sensors._sensor import settle
from probreg.sensors.kinds._polar import RADAR_SIGMAS, PolarSensor


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
    kind: ClassVar[Kind] = Kind(
        "radar3d",
        ("range_m", "azimuth_deg", "elevation_deg"),
        {**RADAR_SIGMAS, "sigma_elevation_deg": "sigma_elevation"},
        coordinates=3,
    )

    def __post_init__(self) -> None:
        settle(self, 3, "sigma_range", "sigma_azimuth", "sigma_elevation")
