"""Reports of a whole recording: how sensors see the common frame, and where reports put targets."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._north import convergence
from probreg.recordings._recording import UNKNOWN, Recording
from probreg.recordings._setup import Setup
from probreg.sensors import Axes, Site, from_axis, sense, turned
from probreg.sensors.frame import LocalFrame
from probreg.typing import FloatArray, IntArray

TARGET_HEIGHT_M = 8_000.0, 5_000.0  # mean and standard deviation where nothing is known


def observing_axes(setup: Setup) -> tuple[Axes, ...]:
    """How each sensor observes a state of `setup.dim` coordinates in the common frame.

    Sensors in `setup.places` are level there, and count from true north; others have the axes of
    the frame, to which `turns` brings the azimuths of moving platforms. Own positions are taken
    from the state first. With the setup of a `Reading`, which knows who reports latitudes.
    """
    frame = None if setup.origin is None else LocalFrame(*setup.origin)
    return tuple(
        sensor.axes(
            Site(
                setup.dim,
                frame,
                None if sensor.name in setup.body_frame else setup.places.get(sensor.name),
                setup.refracted(sensor),
                sensor.name in setup.geodetic,
            )
        )
        for sensor in setup.sensors
    )


def places(recording: Recording, setup: Setup, values: FloatArray) -> FloatArray:
    """Where values (n, q), corrected or not, put the targets (n, d) of the common frame.

    A guess: reports without a height take the one beside them, as it is, else the one of the
    same target that is nearest in time, else the mean of `setup.target_height`. NaN for what
    places nothing, such as heights and bearings.
    """
    height = _heights(recording, setup, values) if setup.dim == 3 else np.zeros(len(recording))
    where = np.full((len(recording), setup.dim), np.nan)
    turn = turns(recording, setup, np.arange(len(recording)))
    for k, (sensor, axes) in enumerate(zip(setup.sensors, observing_axes(setup), strict=True)):
        rows = np.flatnonzero(recording.sensor == k)
        reports = turned(sensor, values[rows, : len(sensor.bias_names)], turn[rows])
        where[rows] = axes.place(reports, height[rows])
    own = recording.own_position
    if own is not None:
        shared = min(setup.dim, own.shape[1])
        where[:, :shared] += own[:, :shared]
    return where


def turns(recording: Recording, setup: Setup, rows: IntArray) -> FloatArray:
    """What brings the azimuths of moving platforms to the axes of the frame, radians.

    The platform's heading for sensors in `body_frame`; else, with an origin, the turn of true
    north where a moving platform is.

    Raises
    ------
    InvalidInputError
        A heading that is not recorded.
    """
    turn = np.zeros(len(rows))
    for k, sensor in enumerate(recording.sensors):
        own = np.flatnonzero(recording.sensor[rows] == k)
        if sensor.azimuth_column is None or not own.size:
            continue
        if sensor.name in setup.body_frame:
            turn[own] = from_axis(sensor, _heading(recording, rows[own], sensor.name))
        elif recording.own_position is not None and sensor.name not in setup.places:
            where = recording.own_position[rows[own]]
            moving = where.any(axis=1)
            turn[own[moving]] = -sense(sensor) * convergence(setup, sensor, where[moving])
    return turn


def _heading(recording: Recording, rows: IntArray, name: str) -> FloatArray:
    heading = None if recording.heading is None else recording.heading[rows]
    if heading is None or not np.isfinite(heading).all():
        raise InvalidInputError(
            f"sensor {name!r} counts azimuth from the platform's heading, which the "
            "recording lacks for some of its reports. Record it, or leave the sensor out of "
            "body_frame."
        )
    return heading


def _heights(recording: Recording, setup: Setup, values: FloatArray) -> FloatArray:
    """Heights (n,) by which to place reports that have none of their own."""
    reported = np.full(len(recording), np.nan)
    for k, sensor in enumerate(setup.sensors):
        vertical = [j for j, name in enumerate(sensor.bias_names) if name in ("height", "z")]
        for j in vertical:
            rows = np.flatnonzero(recording.sensor == k)
            reported[rows] = values[rows, j]
    height = reported.copy()
    if recording.beside is not None:
        came = np.flatnonzero(~recording.alone & np.isfinite(reported))
        lacks = np.isnan(height[recording.beside[came]])
        height[recording.beside[came[lacks]]] = reported[came[lacks]]
    height = _nearest(recording, height)
    usual = TARGET_HEIGHT_M[0] if setup.target_height is None else setup.target_height[0]
    return np.where(np.isnan(height), usual, height)


def _nearest(recording: Recording, given: FloatArray) -> FloatArray:
    """Numbers (n,), those that are NaN from the report of the same target nearest in time."""
    known = np.isfinite(given) & (recording.target != UNKNOWN)
    lost = np.flatnonzero(np.isnan(given) & (recording.target != UNKNOWN))
    if not known.any() or not lost.size:
        return given
    # reports are in order of time already
    order = np.argsort(recording.target, kind="stable")
    place, sure = np.arange(len(order)), known[order]
    before = np.maximum.accumulate(np.where(sure, place, -1))
    after = np.minimum.accumulate(np.where(sure, place, len(order))[::-1])[::-1]
    target, time = recording.target[order], recording.time[order]
    gaps = []
    for other in (before, after):
        safe = np.clip(other, 0, len(order) - 1)
        there = (other == safe) & (target[safe] == target)
        gaps.append(np.where(there, np.abs(time[safe] - time), np.inf))
    nearest = np.where(gaps[0] <= gaps[1], before, after)
    fits = (np.minimum(*gaps) < np.inf) & np.isnan(given[order])
    out = given.copy()
    out[order[fits]] = given[order[nearest[fits]]]
    return out
