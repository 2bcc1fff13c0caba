"""Sensors: how a report becomes a position, and how a bias and noise move that position.

Sign, everywhere in the package: report = truth + bias + noise. A correction subtracts.
"""

from probreg.sensors._sensor import Sensor
from probreg.sensors.bearing import BearingSensor
from probreg.sensors.position import PositionSensor
from probreg.sensors.radar import Radar2D, Radar3D
from probreg.sensors.tracker import Tracker2D

__all__ = ["BearingSensor", "PositionSensor", "Radar2D", "Radar3D", "Sensor", "Tracker2D"]
