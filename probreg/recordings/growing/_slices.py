"""Arrivals cut into slices of time, the same whatever pieces they came in."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from probreg.recordings._arrivals import Arrivals, chosen, in_time, joined
from probreg.recordings._recording import UNKNOWN, Recording
from probreg.recordings._setup import Setup
from probreg.recordings.checks import repetitions
from probreg.recordings.growing._late_kinds import counted
from probreg.typing import BoolArray, FloatArray, IntArray

AHEAD_S = 600.0  # of the latest time, beyond which a time stamp alone is not believed
IN_A_ROW = 20  # reports of one sensor that far ahead, and none of another, are a gap


class Ahead(NamedTuple):
    """Reports whose time stamps were too far ahead to be believed.

    Attributes
    ----------
    reached : ndarray, shape (m,)
        Latest time before each came.
    sensor : ndarray of int, shape (m,)
    by : ndarray, shape (m,)
        Seconds.
    """

    reached: FloatArray = np.zeros(0)
    sensor: IntArray = np.zeros(0, dtype=np.int64)
    by: FloatArray = np.zeros(0)

    def only(self, rows: BoolArray) -> Ahead:
        """Some of them."""
        return Ahead(self.reached[rows], self.sensor[rows], self.by[rows])

    def with_more(self, more: Ahead) -> Ahead:
        """Those of another one after these."""
        return Ahead(
            np.concatenate([self.reached, more.reached]),
            np.concatenate([self.sensor, more.sensor]),
            np.concatenate([self.by, more.by]),
        )


@dataclass(frozen=True, eq=False)
class Buffer:
    """Reports that came and are in no slice yet, in the order in which they came.

    Attributes
    ----------
    arrays : dict of str to ndarray
        Of a `Recording`; empty where there is none.
    labels : tuple of str
    reached : ndarray, shape (n,)
        Latest time when each had come: a report belongs to the slice in which this is.
    newest : float
        Latest time so far, NaN before the first report.
    ahead : Ahead
    doubted : tuple of (int, float)
        Sensor and time of the reports that were ahead just now, none came between.
    """

    arrays: dict[str, Any] = dataclasses.field(default_factory=dict)
    labels: tuple[str, ...] = ()
    reached: FloatArray = dataclasses.field(default_factory=lambda: np.zeros(0))
    newest: float = float("nan")
    ahead: Ahead = dataclasses.field(default_factory=Ahead)
    doubted: tuple[tuple[int, float], ...] = ()

    def __len__(self) -> int:
        return len(self.reached)

    def to_arrays(self) -> dict[str, Any]:
        """Arrays that say it all."""
        return {
            **{f"reports.{name}": array for name, array in self.arrays.items()},
            **{f"ahead.{name}": array for name, array in self.ahead._asdict().items()},
            "labels": np.array(self.labels, dtype=str),
            "reached": self.reached,
            "newest": np.array(self.newest),
            "doubted": np.array(self.doubted, dtype=float).reshape(-1, 2),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any]) -> Buffer:
        """The buffer that `to_arrays` gave."""
        named = [name.partition(".") for name in arrays]
        return cls(
            {key: arrays[f"reports.{key}"] for owner, _, key in named if owner == "reports"},
            tuple(arrays["labels"].tolist()),
            arrays["reached"],
            float(arrays["newest"]),
            Ahead(*(arrays[f"ahead.{name}"] for name in Ahead._fields)),
            tuple((int(sensor), time) for sensor, time in arrays["doubted"].tolist()),
        )


class Slice(NamedTuple):
    """What came within a slice of time.

    Attributes
    ----------
    reports : Recording or None
        In order of time; late ones among them.
    until : float
        End of the slice; no time stamp is later.
    ahead : Ahead
        Reports that were left out.
    repeated : int
        Reports that were left out as they repeat another.
    late_kinds : dict of str to int
        Reports left out as nothing of their kind was there in the first minutes, by kind.
    """

    reports: Recording | None
    until: float
    ahead: Ahead
    repeated: int
    late_kinds: dict[str, int]


def arrive(buffer: Buffer, arrivals: Arrivals) -> Buffer:
    """Put arrivals after what is there.

    A time stamp more than `AHEAD_S` ahead of the latest is believed only if a second sensor, or
    many reports in a row, say the same.
    """
    arrays = arrivals.arrays
    alone = np.flatnonzero(arrays["beside"] == np.arange(len(arrivals)))
    time, sensor = arrays["time"][alone], arrays["sensor"][alone]
    believed, reached, doubted = _walk(buffer, time, sensor)
    lost = np.flatnonzero(~believed)
    ahead = Ahead(reached[lost], sensor[lost].astype(np.int64), time[lost] - reached[lost])
    # what stands beside a report goes with it
    whose = np.searchsorted(alone, arrays["beside"])
    rows = np.flatnonzero(believed[whose])
    known = {label: k for k, label in enumerate(buffer.labels)}
    numbers = [known.setdefault(label, len(known)) for label in arrivals.labels]
    target = np.array([*numbers, UNKNOWN])[arrays["target"]]
    parts = [buffer.arrays] if buffer.arrays else []
    return Buffer(
        joined([*parts, chosen({**arrays, "target": target}, rows)]),
        tuple(known),
        np.concatenate([buffer.reached, reached[whose[rows]]]),
        float(reached[-1]) if len(reached) else buffer.newest,
        buffer.ahead.with_more(ahead),
        doubted,
    )


def _walk(
    buffer: Buffer, time: FloatArray, sensor: IntArray
) -> tuple[BoolArray, FloatArray, tuple[tuple[int, float], ...]]:
    """Which reports are believed, the latest time after each, and those in doubt at the end."""
    newest = time[0] if np.isnan(buffer.newest) else buffer.newest
    latest = np.maximum.accumulate(np.concatenate([[newest], time]))
    if (np.diff(latest) <= AHEAD_S).all():
        return np.ones(len(time), dtype=bool), latest[1:], ()
    believed, reached = np.ones(len(time), dtype=bool), np.empty(len(time))
    doubted = list(buffer.doubted)
    for k, (t, s) in enumerate(zip(time.tolist(), sensor.tolist(), strict=True)):
        if t - newest <= AHEAD_S:
            doubted = []
        else:
            same = [other for other, when in doubted if abs(when - t) <= AHEAD_S]
            believed[k] = any(other != s for other in same) or len(same) >= IN_A_ROW - 1
            doubted = [] if believed[k] else [*doubted, (s, t)][-IN_A_ROW:]
        newest = max(newest, t) if believed[k] else newest
        reached[k] = newest
    return believed, reached, tuple(doubted)


def complete(buffer: Buffer, until: float) -> bool:
    """Whether reports have come of a time after the end of a slice."""
    return buffer.newest > until


def cut(buffer: Buffer, setup: Setup, until: float) -> tuple[Slice, Buffer]:
    """Take what came until a time; what came later, of whatever time, stays."""
    count = int(np.searchsorted(buffer.reached, until, side="right"))
    early = buffer.ahead.reached <= until
    rest = dataclasses.replace(
        buffer,
        arrays=chosen(buffer.arrays, np.arange(count, len(buffer))) if buffer.arrays else {},
        reached=buffer.reached[count:],
        ahead=buffer.ahead.only(~early),
    )
    reports, repeated = None, 0
    late_kinds: dict[str, int] = {}
    if count:
        own = chosen(buffer.arrays, np.arange(count))
        own, late_kinds = counted(own, len(setup.sensors))
        arrays, labels = _labelled(own, buffer.labels)
        reports, repeated = _once(in_time(setup, arrays, labels), setup)
    if rest.arrays:
        arrays, labels = _labelled(rest.arrays, buffer.labels)
        rest = dataclasses.replace(rest, arrays=arrays, labels=labels)
    return Slice(reports, until, buffer.ahead.only(early), repeated, late_kinds), rest


def _labelled(
    arrays: dict[str, Any], labels: tuple[str, ...]
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Arrays whose targets are numbered in the order of their labels, and these."""
    used = np.unique(arrays["target"])
    used = used[used != UNKNOWN]
    order = sorted(used.tolist(), key=labels.__getitem__)
    numbers = np.full(len(labels) + 1, UNKNOWN)
    numbers[order] = np.arange(len(order))
    return {**arrays, "target": numbers[arrays["target"]]}, tuple(labels[k] for k in order)


def _once(recording: Recording, setup: Setup) -> tuple[Recording, int]:
    """The recording without reports that repeat another, and how many these are."""
    pairs = repetitions(recording)
    if not len(pairs):
        return recording, 0
    beside = np.arange(len(recording)) if recording.beside is None else recording.beside
    rows = np.flatnonzero(~np.isin(beside, pairs[:, 1]))
    names = ("time", "sensor", "target", "values", "own_position", "heading", "beside")
    arrays = {name: getattr(recording, name) for name in names}
    given = {name: array for name, array in arrays.items() if array is not None}
    return in_time(setup, chosen(given, rows), recording.labels), len(pairs)
