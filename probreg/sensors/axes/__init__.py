"""What kinds of report say of a state, in their own axes, scaled to metres.

A sensor at p whose level is turned by M sees l = M (x - p) of a target at x, all in one rigid
frame. Each kind gives the noise-free report h(x), a factor rho that makes its errors metres, and
H = rho dh/dx. Planar and spatial frames alike.
"""

from probreg.sensors.axes._axes import Axes, Observed, Site
from probreg.sensors.axes._ellipsoid import EARTH_RADIUS_M, fall
from probreg.sensors.axes._geodetic import GeodeticAxes
from probreg.sensors.axes._heights import HeightAxes
from probreg.sensors.axes._polar import PolarAxes, polar_axes
from probreg.sensors.axes._positions import PositionAxes

__all__ = [
    "EARTH_RADIUS_M",
    "Axes",
    "GeodeticAxes",
    "HeightAxes",
    "Observed",
    "PolarAxes",
    "PositionAxes",
    "Site",
    "fall",
    "polar_axes",
]
