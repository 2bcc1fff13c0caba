"""What every kind of report offers, and what it must know of where its sensor stands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

from probreg.typing import BoolArray, FloatArray

if TYPE_CHECKING:
    from probreg.sensors.frame import LocalFrame


class Observed(NamedTuple):
    """Noise-free reports of q components and their sensitivity.

    Attributes
    ----------
    value : ndarray, shape (n, q)
        h(x), metres and radians.
    gradient : ndarray, shape (n, q, d)
        H = rho dh/dx.
    factor : ndarray, shape (n, q)
        rho, metres a unit of the component. Zero, with a gradient of zero, where the component
        says nothing: an angle on the vertical of its sensor.
    """

    value: FloatArray
    gradient: FloatArray
    factor: FloatArray


class Axes(Protocol):
    """A kind of report."""

    @property
    def angles(self) -> BoolArray:
        """Which components are angles, (q,): their residuals are wrapped."""

    @property
    def vertical(self) -> BoolArray:
        """Which components say something of the height, (q,)."""

    def observe(self, x: FloatArray) -> Observed:
        """Noise-free reports of positions (n, d)."""

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """Positions (n, d) of reports (n, q), NaN where they do not say; a guess to start from.

        `height` (n,), above the earth, is taken where the report gives none.
        """


@dataclass(frozen=True)
class Site:
    """What a sensor's reports refer to, beside the sensor itself.

    Parameters
    ----------
    dim : int
        Coordinates of the common frame, 2 or 3.
    frame : LocalFrame, optional
        The common frame on the earth; without it the earth is flat.
    place : tuple of float, optional
        Latitude, longitude (degrees) and height (metres) of a sensor that is level there and
        counts from true north. Others have the axes of the common frame.
    refraction : bool
        Whether its reports are refracted.
    geodetic : bool
        Whether positions are reported as latitude, longitude and height.
    """

    dim: int = 2
    frame: LocalFrame | None = None
    place: tuple[float, float, float] | None = None
    refraction: bool = False
    geodetic: bool = False
