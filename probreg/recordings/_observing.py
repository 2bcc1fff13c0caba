"""What a report says of where its target is, by the kind of sensor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.sensors import BearingSensor, Sensor
from probreg.sensors.geometry import azimuth_and_gradient, azimuth_from_north, wrap_angle
from probreg.typing import FloatArray, IntArray

_AZIMUTHS = ("azimuth", "bearing")


class Seen(NamedTuple):
    """Equations of reports about where their targets are: e = G x + D bias + noise C.

    Shapes (n, d), (n, d, d), (n, d, d) and (n, d, q); rows beyond a report's equations are zero.
    """

    e: FloatArray
    G: FloatArray
    C: FloatArray
    D: FloatArray


def gives_position(sensor: Sensor | BearingSensor) -> bool:
    """Whether one report of a sensor places a target."""
    return not isinstance(sensor, BearingSensor)


def places(recording: Recording, values: FloatArray, turn: FloatArray) -> FloatArray:
    """Where values (n, q), corrected or not, put the targets (n, d); NaN for bearings.

    `turn` is that of `turns` for every report.
    """
    where = np.full((len(recording), recording.sensors[0].dim), np.nan)
    for k, sensor in enumerate(recording.sensors):
        if gives_position(sensor):
            rows = np.flatnonzero(recording.sensor == k)
            reports = turned(sensor, values[rows, : len(sensor.bias_names)], turn[rows])
            where[rows] = sensor.to_cartesian(reports)
    return where if recording.own_position is None else where + recording.own_position


def observe(sensor: Sensor, reports: FloatArray, own: FloatArray, at: FloatArray | None) -> Seen:
    """Equations of reports (n, q) from own positions (n, d), about targets at (n, d).

    Without `at` they are about where the reports themselves put the targets; a bearing puts
    them nowhere and gives no equation then.
    """
    if isinstance(sensor, BearingSensor):
        return _bearing(sensor, reports, own, at)
    local = sensor.to_cartesian(reports)
    where = local if at is None else at - own
    G = np.broadcast_to(np.eye(sensor.dim), (len(reports), sensor.dim, sensor.dim))
    return Seen(local + own, G, sensor.covariance(where), sensor.sensitivity(where))


def _bearing(
    sensor: BearingSensor, reports: FloatArray, own: FloatArray, at: FloatArray | None
) -> Seen:
    n, d = own.shape
    e, G, C, D = np.zeros((n, d)), np.zeros((n, d, d)), np.zeros((n, d, d)), np.zeros((n, d, 1))
    if at is None:
        return Seen(e, G, C, D)
    azimuth, by_x, by_y = azimuth_and_gradient(*(at - own).T)
    G[:, 0, 0], G[:, 0, 1] = by_x, by_y
    left = wrap_angle(counter_clockwise(sensor, reports[:, 0]) - azimuth)
    e[:, 0] = left + np.einsum("nd,nd->n", G[:, 0], at)
    C[:, 0, 0] = sensor.sigma_bearing**2
    D[:, 0, 0] = -1.0 if sensor.from_north else 1.0
    return Seen(e, G, C, D)


def true_reports(sensor: Sensor, where: FloatArray, own: FloatArray) -> FloatArray:
    """Noise-free reports (n, q) on targets at (n, d), azimuths from the axes."""
    if isinstance(sensor, BearingSensor):
        return sensor.to_report(where, own)[:, None]
    return sensor.to_report(where - own)


def counter_clockwise(sensor: Sensor | BearingSensor, azimuth: FloatArray) -> FloatArray:
    """Azimuths from x, counter-clockwise, of azimuths in the sensor's convention."""
    return azimuth_from_north(azimuth) if getattr(sensor, "from_north", False) else azimuth


def turned(sensor: Sensor, reports: FloatArray, turn: FloatArray) -> FloatArray:
    """Reports (n, q) with angles (n,) added to their azimuth."""
    for column, name in enumerate(sensor.bias_names):
        if name in _AZIMUTHS:
            reports = reports.copy()
            reports[:, column] += turn
    return reports


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
        clockwise = getattr(sensor, "from_north", False)
        turn[own] = 0.5 * np.pi - heading if clockwise else heading
    return turn
