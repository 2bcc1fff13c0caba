"""Sensors: how a report becomes a position, and how a bias and noise move that position.

Sign, everywhere in the package: report = truth + bias + noise. A correction subtracts.

A new kind is a module in `kinds` with one public class, its test, and a line here.
"""

from probreg.sensors._kind import Kind
from probreg.sensors._sensor import Equations, PlacingSensor, Sensor
from probreg.sensors.axes import Axes, Observed, Site
from probreg.sensors.azimuths import counter_clockwise, from_axis, sense, turned
from probreg.sensors.kinds import known_kinds
from probreg.sensors.kinds.barometer import Barometer
from probreg.sensors.kinds.bearing import BearingSensor
from probreg.sensors.kinds.height import Height
from probreg.sensors.kinds.position import PositionSensor
from probreg.sensors.kinds.radar2d import Radar2D
from probreg.sensors.kinds.radar3d import Radar3D
from probreg.sensors.kinds.tracker2d import Tracker2D

__all__ = [
    "Axes",
    "Barometer",
    "BearingSensor",
    "Equations",
    "Height",
    "Kind",
    "Observed",
    "PlacingSensor",
    "PositionSensor",
    "Radar2D",
    "Radar3D",
    "Sensor",
    "Site",
    "Tracker2D",
    "counter_clockwise",
    "from_axis",
    "known_kinds",
    "sense",
    "turned",
]
