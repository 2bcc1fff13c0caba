"""True north of moving platforms, and the coordinates of sensors that report latitudes."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._setup import Setup
from probreg.sensors import Sensor
from probreg.sensors.axes import GeodeticAxes
from probreg.sensors.frame import LocalFrame
from probreg.typing import FloatArray


def convergence(setup: Setup, sensor: Sensor, own: FloatArray) -> FloatArray:
    """Clockwise angles (m,) from the frame's north to true north where a platform is.

    Own positions (m, d) add to the sensor's; without an origin north is the frame's.
    """
    place = own[:, :2] + (0.0 if sensor.position is None else np.asarray(sensor.position[:2]))
    if setup.origin is None or not len(place):
        return np.zeros(len(place))
    if (place == place[0]).all():
        return np.full(len(place), LocalFrame(*setup.origin).convergence(place[0]))
    return LocalFrame(*setup.origin).convergence(place)


def geodetic_axes(setup: Setup, sensor: Sensor) -> GeodeticAxes:
    """Between latitudes, longitudes and heights and the values of a position sensor.

    Raises
    ------
    InvalidInputError
        No origin.
    """
    if setup.origin is None:
        raise InvalidInputError(
            f"sensor {sensor.name!r} reports in latitude and longitude, and the setup has no "
            "place on the earth; give it an origin."
        )
    return GeodeticAxes(setup.origin, sensor.dim, sensor.dim)
