"""Residuals of single reports: what a sensor says less what the other sensors say."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from probreg.recordings import Recording, Setup, corrected_values, places, turns
from probreg.sensors import Sensor, turned
from probreg.sensors.geometry import wrap_angle
from probreg.typing import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Residuals:
    """Reports against straight lines between neighbouring reports of the other sensors.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Corrected.
    where : ndarray, shape (n, d)
        Corrected reports in the common frame, metres; NaN for bearings.
    values : ndarray, shape (n, q)
        Corrected reports.
    residual : ndarray, shape (n, q)
        In the sensor's components and SI units; NaN where no other sensor reported the target
        just before and just after.
    """

    time: FloatArray
    where: FloatArray
    values: FloatArray
    residual: FloatArray


def report_residuals(recording: Recording, setup: Setup, theta: FloatArray) -> Residuals:
    """Residuals after correction by theta (p,), in the order of the recording."""
    values, time = corrected_values(recording, setup, theta)
    turn = turns(recording, setup, np.arange(len(recording)))
    shape = (len(recording), recording.sensors[0].dim)
    where = places(recording, setup, values)
    own = np.zeros(shape) if recording.own_position is None else recording.own_position
    residual = np.full(values.shape, np.nan)
    for k, sensor in enumerate(recording.sensors):
        line = between(recording, time, where, k, setup.window_s)
        seen, q = line.rows, len(sensor.bias_names)
        said = turned(sensor, sensor.to_report(line.expected, own[seen]), -turn[seen])
        residual[seen, :q] = _difference(sensor, values[seen, :q], said)
    return Residuals(time, where, values, residual)


def _difference(sensor: Sensor, reports: FloatArray, expected: FloatArray) -> FloatArray:
    """Reports (n, q) less what is expected, angles within half a turn."""
    left = reports - expected
    angles = np.array(sensor.bias_units) == "rad"
    left[:, angles] = wrap_angle(left[:, angles])
    return left


class Between(NamedTuple):
    """Reports between two of other sensors, and the line between those at their time.

    Shapes (n,), (n,), (n,), (n,), (n,) and (n, d): reports, the others before and after, the share
    of the gap gone, the gap in seconds, and where the line has the target.
    """

    rows: IntArray
    left: IntArray
    right: IntArray
    share: FloatArray
    gap: FloatArray
    expected: FloatArray


def between(
    recording: Recording, time: FloatArray, where: FloatArray, k: int, window_s: float
) -> Between:
    """Reports of sensor k between two of the others, and the line between those at its time."""
    known = recording.target >= 0
    mine = np.flatnonzero(known & (recording.sensor == k))
    others = np.flatnonzero(known & (recording.sensor != k) & np.isfinite(where[:, 0]))
    if not mine.size or len(others) < 2:
        none, zero_s = mine[:0], time[:0]
        return Between(none, none, none, zero_s, zero_s, where[:0])
    others = others[np.lexsort((time[others], recording.target[others]))]
    # one number that orders by target, then time
    zero, span = time.min(), np.ptp(time) + 1.0
    key = recording.target * span + (time - zero)
    after = np.clip(np.searchsorted(key[others], key[mine], side="right"), 1, len(others) - 1)
    left, right = others[after - 1], others[after]
    gap = time[right] - time[left]
    fine = (recording.target[left] == recording.target[mine]) & (
        recording.target[right] == recording.target[mine]
    )
    fine &= (gap <= window_s) & (time[left] <= time[mine]) & (time[right] >= time[mine])
    mine, left, right, gap = mine[fine], left[fine], right[fine], gap[fine]
    share = np.divide(time[mine] - time[left], gap, out=np.zeros(len(gap)), where=gap > 0.0)
    expected = where[left] + share[:, None] * (where[right] - where[left])
    return Between(mine, left, right, share, gap, expected)


@dataclass(frozen=True)
class Spread:
    """Median and robust standard deviation of residuals, SI units."""

    median: float
    sd: float


def spread(residual: FloatArray) -> Spread:
    """Median, and 1.4826 times the median distance from it."""
    if not residual.size:
        return Spread(np.nan, np.nan)
    middle = float(np.median(residual))
    return Spread(middle, 1.4826 * float(np.median(np.abs(residual - middle))))


@dataclass(frozen=True, eq=False)
class Component:
    """Residuals of one component of one sensor before and after, of the same reports.

    Attributes
    ----------
    sensor, name, unit : str
        Unit inside: "m" or "rad".
    rows : ndarray of int, shape (k,)
        Reports of the recording.
    before, after : ndarray, shape (k,)
    """

    sensor: str
    name: str
    unit: str
    rows: IntArray
    before: FloatArray
    after: FloatArray

    @cached_property
    def spreads(self) -> tuple[Spread, Spread]:
        """Median and robust standard deviation before and after."""
        return spread(self.before), spread(self.after)


def components(recording: Recording, before: Residuals, after: Residuals) -> list[Component]:
    """Every component of every sensor that has residuals both before and after."""
    found = []
    for k, sensor in enumerate(recording.sensors):
        names = zip(sensor.bias_names, sensor.bias_units, strict=True)
        for j, (name, unit) in enumerate(names):
            both: BoolArray = np.isfinite(before.residual[:, j]) & np.isfinite(after.residual[:, j])
            rows = np.flatnonzero(both & (recording.sensor == k))
            if rows.size:
                first, second = before.residual[rows, j], after.residual[rows, j]
                found.append(Component(sensor.name, name, unit, rows, first, second))
    return found
