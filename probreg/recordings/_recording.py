"""What every file format is read into: reports of several sensors in order of time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors import Sensor
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import finite_array

UNKNOWN = -1


@dataclass(frozen=True, eq=False)
class Recording:
    """Reports of several sensors, each at its own time.

    Parameters
    ----------
    sensors : tuple of Sensor
    sensor : ndarray of int, shape (n,)
        Which of the sensors made each report.
    time : ndarray, shape (n,)
        Seconds, not decreasing.
    values : ndarray, shape (n, q)
        Reports in the sensor's components and units (metres, radians), in its own axes: slant
        range, azimuth from its own north; NaN for what is not reported, and beyond the
        components of a sensor that has fewer than q.
    target : ndarray of int, shape (n,)
        Identity of the target as the recording gives it, -1 where it gives none.
    labels : tuple of str
        Names of the identities, in order of their numbers.
    own_position : ndarray, shape (n, d), optional
        Position of a moving platform at each report, metres in the common frame, added to the
        sensor's own position; zero for sensors that do not move.
    heading : ndarray, shape (n,), optional
        Of the platform, radians from the x axis counter-clockwise; NaN where not recorded.
    beside : ndarray of int, shape (n,), optional
        Number of the report that each came with, such as the plot that carried a height; its
        own for reports that stand alone. Reports that came together are of one target.

    Raises
    ------
    InvalidInputError
        Mismatched lengths, a sensor number out of range, times out of order, reports that their
        sensor refuses.
    """

    sensors: tuple[Sensor, ...]
    sensor: IntArray
    time: FloatArray
    values: FloatArray
    target: IntArray
    labels: tuple[str, ...] = ()
    own_position: FloatArray | None = None
    heading: FloatArray | None = None
    beside: IntArray | None = None

    def __post_init__(self) -> None:
        time = finite_array("time", self.time, (None,))
        n, k = len(time), len(self.sensors)
        names = [s.name for s in self.sensors]
        if len(set(names)) < k:
            raise InvalidInputError(f"sensor names {names} repeat; give each sensor its own.")
        sensor, target = np.asarray(self.sensor), np.asarray(self.target)
        values = np.asarray(self.values, dtype=float)
        for name, array in (("sensor", sensor), ("target", target), ("values", values)):
            if len(array) != n:
                raise InvalidInputError(f"{name} has {len(array)} rows, time has {n}.")
        late = np.flatnonzero(np.diff(time) < 0.0)
        if late.size:
            raise InvalidInputError(f"time goes back after report {late[0]}; sort the reports.")
        if n and not (sensor.min() >= 0 and sensor.max() < k):
            raise InvalidInputError(f"a sensor number is outside 0 to {k - 1}.")
        values = values.copy()
        for index, own in enumerate(self.sensors):
            rows, q = np.flatnonzero(sensor == index), len(own.bias_names)
            values[rows, :q] = own.check(values[rows, :q])
            values[rows, q:] = np.nan
        fields = {"time": time, "sensor": sensor, "target": target, "values": values}
        if self.own_position is not None:
            fields["own_position"] = finite_array("own_position", self.own_position, (n, None))
        if self.heading is not None:
            heading = np.asarray(self.heading, dtype=float)
            if heading.shape != (n,):
                raise InvalidInputError(f"heading has shape {heading.shape}, not ({n},).")
            fields["heading"] = heading
        if self.beside is not None:
            fields["beside"] = _together(np.asarray(self.beside), n)
        for name, array in fields.items():
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.time)

    @property
    def alone(self) -> BoolArray:
        """Which reports (n,) did not come with another one."""
        if self.beside is None:
            return np.ones(len(self), dtype=bool)
        found: BoolArray = self.beside == np.arange(len(self))
        return found

    def only(self, *names: str) -> Recording:
        """The reports of some of the sensors.

        Raises
        ------
        InvalidInputError
            A sensor that is not there.
        """
        known = [sensor.name for sensor in self.sensors]
        strange = set(names) - set(known)
        if strange:
            raise InvalidInputError(f"no sensor {sorted(strange)}; there are {known}.")
        chosen = [k for k, name in enumerate(known) if name in names]
        own = self._where(np.isin(self.sensor, chosen))
        sensors = tuple(self.sensors[k] for k in chosen)
        return replace(own, sensors=sensors, sensor=np.searchsorted(chosen, own.sensor))

    def during(self, after: float, until: float) -> Recording:
        """The reports later than `after`, up to `until`, seconds."""
        return self._where((self.time > after) & (self.time <= until))

    def _where(self, rows: BoolArray) -> Recording:
        """Some of the reports; those that came with others only together with them."""
        if self.beside is not None:
            rows = rows & rows[self.beside]
        beside = None if self.beside is None else (np.cumsum(rows) - 1)[self.beside[rows]]
        return replace(
            self,
            sensor=self.sensor[rows],
            time=self.time[rows],
            values=self.values[rows],
            target=self.target[rows],
            own_position=None if self.own_position is None else self.own_position[rows],
            heading=None if self.heading is None else self.heading[rows],
            beside=beside,
        )


def _together(beside: IntArray, n: int) -> IntArray:
    fits = beside.shape == (n,) and beside.dtype.kind in "iu"
    if not fits or ((beside < 0) | (beside >= n)).any() or (beside[beside] != beside).any():
        raise InvalidInputError(
            f"beside must be ({n},) numbers of reports, each of which stands alone."
        )
    return beside
