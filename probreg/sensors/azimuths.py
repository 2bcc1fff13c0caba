"""How a sensor's azimuth counts: from x counter-clockwise, or from north clockwise."""

from __future__ import annotations

import numpy as np

from probreg.sensors._sensor import Sensor
from probreg.sensors.geometry import azimuth_from_north
from probreg.typing import FloatArray


def counter_clockwise(sensor: Sensor, azimuth: FloatArray) -> FloatArray:
    """Azimuths (n,) from x, counter-clockwise, of azimuths as the sensor counts them."""
    return azimuth_from_north(azimuth) if sensor.from_north else azimuth


def from_axis(sensor: Sensor, azimuth: FloatArray) -> FloatArray:
    """Azimuths (n,) as the sensor counts them, not wrapped, of azimuths from x."""
    return 0.5 * np.pi - azimuth if sensor.from_north else azimuth


def sense(sensor: Sensor) -> float:
    """What a counter-clockwise turn of one does to the sensor's azimuth: 1, or -1."""
    return -1.0 if sensor.from_north else 1.0


def turned(sensor: Sensor, reports: FloatArray, turn: FloatArray) -> FloatArray:
    """Reports (n, q) with angles (n,) added to their azimuth, where they have one."""
    if sensor.azimuth_column is None:
        return reports
    reports = reports.copy()
    reports[:, sensor.azimuth_column] += turn
    return reports
