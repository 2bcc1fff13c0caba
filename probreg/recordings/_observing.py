"""Reports of a whole recording: where they put their targets, and how headings turn them."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.sensors import from_axis, turned
from probreg.sensors.axes import Axes
from probreg.typing import FloatArray, IntArray


def places(recording: Recording, setup: Setup, values: FloatArray) -> FloatArray:
    """Where values (n, q), corrected or not, put the targets (n, d); NaN for bearings."""
    where = np.full((len(recording), setup.dim), np.nan)
    turn = turns(recording, setup, np.arange(len(recording)))
    for k, sensor in enumerate(recording.sensors):
        rows = np.flatnonzero(recording.sensor == k)
        reports = turned(sensor, values[rows, : len(sensor.bias_names)], turn[rows])
        own = None if recording.own_position is None else recording.own_position[rows]
        where[rows] = sensor.to_cartesian(reports, own)
    return where


def turns(recording: Recording, setup: Setup, rows: IntArray) -> FloatArray:
    """What the platform's heading adds to the azimuths of body-frame sensors, radians.

    Raises
    ------
    InvalidInputError
        A heading that is not recorded.
    """
    turn = np.zeros(len(rows))
    for k, sensor in enumerate(recording.sensors):
        own = np.flatnonzero(recording.sensor[rows] == k)
        if sensor.name not in setup.body_frame or not own.size:
            continue
        heading = None if recording.heading is None else recording.heading[rows[own]]
        if heading is None or not np.isfinite(heading).all():
            raise InvalidInputError(
                f"sensor {sensor.name!r} counts azimuth from the platform's heading, which the "
                "recording lacks for some of its reports. Record it, or leave the sensor out of "
                "body_frame."
            )
        turn[own] = from_axis(sensor, heading)
    return turn


def observing_axes(setup: Setup) -> tuple[Axes, ...]:
    """How each sensor of a setup reports targets in the common frame."""
    return tuple(sensor.axes() for sensor in setup.sensors)
