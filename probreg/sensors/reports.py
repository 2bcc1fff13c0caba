"""Reports of several sensors on the same targets: the data that scenes and recordings give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from probreg.errors import InvalidInputError
from probreg.sensors import BearingSensor, PlacingSensor, Sensor
from probreg.typing import FloatArray, IntArray
from probreg.validation import finite_array


@dataclass(frozen=True, eq=False)
class SensorReports:
    """Reports of one sensor on unknown targets: one frame, not associated.

    Parameters
    ----------
    sensor : PlacingSensor
    values : ndarray, shape (n, q)
        Reports in the sensor's components and units; n may be zero.

    Raises
    ------
    InvalidInputError
        A wrong shape, NaN or infinity, degrees by the look of them, a sensor whose reports place
        no target.
    """

    sensor: PlacingSensor
    values: FloatArray

    def __post_init__(self) -> None:
        refuse_bearings(self.sensor)
        object.__setattr__(self, "values", self.sensor.check(self.values))

    def __len__(self) -> int:
        return len(self.values)

    def positions(self, bias: FloatArray | float = 0.0) -> FloatArray:
        """Positions (..., n, d) after correction by biases of shape (..., 1, q) or a scalar."""
        return self.sensor.to_cartesian(self.values - bias)


def refuse_bearings(sensor: Sensor) -> None:
    """Refuse a sensor whose single reports place no target, so that none can be compared."""
    if not sensor.gives_position:
        raise InvalidInputError(
            f"one report of sensor {sensor.name!r} ({', '.join(sensor.bias_names)}) places no "
            "target. Put its reports into a Recording, or into BearingReports of one emitter."
        )


def pair_up(first: SensorReports, second: SensorReports, pairs: IntArray) -> AssociatedReports:
    """Put paired reports into rows; pairs (k, 2) are row numbers in `first` and `second`."""
    sensors = (first.sensor, second.sensor)
    return AssociatedReports(sensors, (first.values[pairs[:, 0]], second.values[pairs[:, 1]]))


@dataclass(frozen=True, eq=False)
class AssociatedReports:
    """Rows of reports that are believed to come from one target at one instant.

    Parameters
    ----------
    sensors : tuple of PlacingSensor
        The k sensors that saw every row, k >= 2.
    values : tuple of ndarray
        One array (n, q) a sensor: its reports in its own components and units.
    time : ndarray, shape (n,), optional
        Time of each row, seconds.
    tracks : ndarray of int, shape (n, k), optional
        Number of the track that each sensor itself put the report in. Sensors number
        their tracks independently; a row says which of them were paired.

    Raises
    ------
    InvalidInputError
        Fewer than two sensors, unequal lengths or dimensions, NaN, equal sensor names, sensors
        whose reports place no target.
    """

    sensors: tuple[PlacingSensor, ...]
    values: tuple[FloatArray, ...]
    time: FloatArray | None = None
    tracks: IntArray | None = None

    def __post_init__(self) -> None:
        names = [sensor.name for sensor in self.sensors]
        if len(names) < 2:
            raise InvalidInputError(
                f"{len(names)} sensor given: a bias shows only where at least two sensors, or a "
                "sensor and a reference, report the same target."
            )
        if len(set(names)) < len(names):
            raise InvalidInputError(f"sensor names {names} repeat; give each sensor its own.")
        if len(self.values) != len(names):
            raise InvalidInputError(f"{len(self.values)} report arrays for {len(names)} sensors.")
        for sensor in self.sensors:
            refuse_bearings(sensor)
        dims = {sensor.name: sensor.dim for sensor in self.sensors}
        if len(set(dims.values())) > 1:
            raise InvalidInputError(f"sensors of different dimension in one row: {dims}.")
        checked = tuple(s.check(v) for s, v in zip(self.sensors, self.values, strict=True))
        lengths = {name: len(v) for name, v in zip(names, checked, strict=True)}
        if len(set(lengths.values())) > 1:
            raise InvalidInputError(f"associated reports differ in number: {lengths}.")
        object.__setattr__(self, "values", checked)
        if self.time is not None:
            object.__setattr__(self, "time", finite_array("time", self.time, (len(self),)))
        if self.tracks is not None:
            tracks = np.asarray(self.tracks)
            if tracks.shape != (len(self), len(names)):
                raise InvalidInputError(
                    f"tracks has shape {tracks.shape}; expected ({len(self)}, {len(names)})."
                )
            object.__setattr__(self, "tracks", tracks)

    def __len__(self) -> int:
        return len(self.values[0])

    def every(self, step: int) -> AssociatedReports:
        """Every step-th row."""
        return AssociatedReports(
            self.sensors,
            tuple(value[::step] for value in self.values),
            None if self.time is None else self.time[::step],
            None if self.tracks is None else self.tracks[::step],
        )

    def positions(self, *, unbiased: bool = True) -> tuple[FloatArray, ...]:
        """Convert every sensor's reports to positions (n, d) in the common frame."""
        pairs = zip(self.sensors, self.values, strict=True)
        return tuple(sensor.to_cartesian(v, unbiased=unbiased) for sensor, v in pairs)


def smoothed_positions(reports: AssociatedReports, window: int = 21) -> tuple[FloatArray, ...]:
    """Centred running median of every sensor's own tracks: outliers and pairing cannot reach it.

    Parameters
    ----------
    reports : AssociatedReports
        Reports with `time` and `tracks`.
    window : int
        Number of reports of the track, odd.

    Returns
    -------
    tuple of ndarray, shape (n, d)
        A smoothed position for each report, in row order, metres.

    Raises
    ------
    InvalidInputError
        No time or tracks, or an even window.
    """
    if reports.tracks is None or reports.time is None:
        raise InvalidInputError("smoothing needs the time and the track number of every report.")
    if window < 1 or window % 2 == 0:
        raise InvalidInputError(f"window is {window}; a centred median needs an odd number.")
    smoothed = []
    for column, raw in enumerate(reports.positions(unbiased=False)):
        track = reports.tracks[:, column]
        order = np.lexsort((reports.time, track))
        bounds = np.flatnonzero(np.diff(track[order])) + 1
        out = np.empty_like(raw)
        for rows in np.split(order, bounds):
            out[rows] = median_filter(raw[rows], size=(window, 1), mode="nearest")
        smoothed.append(out)
    return tuple(smoothed)


@dataclass(frozen=True, eq=False)
class BearingReports:
    """Bearings of one emitter, reported from known own positions.

    Parameters
    ----------
    sensor : BearingSensor
    bearing : ndarray, shape (n,) or (n, 1)
        In the sensor's convention, radians; (n,) inside.
    own_position : ndarray, shape (n, 2)
        Metres.
    time : ndarray, shape (n,), optional
        Seconds.

    Raises
    ------
    InvalidInputError
        Mismatched shapes, NaN or infinity, degrees by the look of them.
    """

    sensor: BearingSensor
    bearing: FloatArray
    own_position: FloatArray
    time: FloatArray | None = None

    def __post_init__(self) -> None:
        shape = (None, 1)[: max(np.ndim(self.bearing), 1)]
        label = f"bearing of sensor {self.sensor.name!r}"
        column = finite_array(label, self.bearing, shape).reshape(-1, 1)
        bearing = self.sensor.check(column)[:, 0]
        object.__setattr__(self, "bearing", bearing)
        own = finite_array("own_position", self.own_position, (len(bearing), 2))
        object.__setattr__(self, "own_position", own)
        if self.time is not None:
            object.__setattr__(self, "time", finite_array("time", self.time, (len(bearing),)))

    def __len__(self) -> int:
        return len(self.bearing)
