"""What must hold of a recording whatever file it came from; each check raises or is silent."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._recording import UNKNOWN, Recording
from probreg.typing import IntArray

FARTHEST_S = 60.0  # between the times of a sensor and those of the others


def _report(number: int) -> str:
    return f"report {number}"


def several_sensors(recording: Recording) -> None:
    """Refuse fewer than two sensors, and sensors without a report.

    Heights beside the reports of others are no second opinion of where those have a target.
    """
    names = [sensor.name for sensor in recording.sensors]
    counts = np.bincount(recording.sensor, minlength=len(names))
    alone = np.bincount(recording.sensor[recording.alone], minlength=len(names))
    silent = [name for name, count in zip(names, counts, strict=True) if count == 0]
    if len(names) > 1 and silent:
        raise InvalidInputError(
            f"sensor {silent[0]!r} has no report. Take it out of the setup, or correct its name: "
            f"with reports are {[n for n, c in zip(names, counts, strict=True) if c]}."
        )
    if (alone > 0).sum() < 2:
        own = [name for name, count in zip(names, alone, strict=True) if count] or names
        raise InvalidInputError(
            f"one sensor only ({', '.join(own)}): a bias shows in what two sensors, or a sensor "
            "and a reference, say of one target. Add the reports of another."
        )


def repetitions(recording: Recording) -> IntArray:
    """Pairs (m, 2) of reports that agree in sensor, time, target and every value.

    Of what came beside others only these are compared.
    """
    alone = np.flatnonzero(recording.alone)
    columns = [
        column[alone]
        for column in (recording.time, recording.sensor, recording.target, *recording.values.T)
    ]
    order = np.lexsort(columns[::-1])
    same = np.ones(max(len(alone) - 1, 0), dtype=bool)
    for column in columns:
        ahead, behind = column[order[1:]], column[order[:-1]]
        same &= (ahead == behind) | ((ahead != ahead) & (behind != behind))
    twice = np.flatnonzero(same)
    return np.sort(alone[np.stack([order[twice], order[twice + 1]], axis=1)], axis=1)


def no_duplicates(recording: Recording, where: Callable[[int], str] = _report) -> None:
    """Refuse two reports that agree in sensor, time, target and every value."""
    pairs = repetitions(recording)
    if len(pairs):
        first, second = pairs[0].tolist()
        raise InvalidInputError(
            f"{where(second)} repeats {where(first)}: same sensor, time, target and values "
            f"({len(pairs)} such in all). Remove the repetitions; they would count twice."
        )


def several_at_once(recording: Recording) -> IntArray:
    """Count, by sensor (k,), reports of a target at a time of which it has another one."""
    known = np.flatnonzero(recording.target != UNKNOWN)
    columns = (recording.time[known], recording.target[known], recording.sensor[known])
    order = np.lexsort(columns)
    same = np.ones(max(len(order) - 1, 0), dtype=bool)
    for column in columns:
        same &= np.diff(column[order]) == 0
    again = recording.sensor[known[order[1:][same]]] if same.any() else known[:0]
    return np.bincount(again, minlength=len(recording.sensors))


def clocks_overlap(recording: Recording) -> None:
    """Refuse a sensor that reports at no time, within a minute, at which another does."""
    spans = []
    own = _own_reports(recording)
    for reports in own.values():
        time = recording.time[reports]
        spans.append((time[0], time[-1]))
    for k, (start, end) in zip(own, spans, strict=True):
        gaps = [max(s - end, start - e) for j, (s, e) in zip(own, spans, strict=True) if j != k]
        if min(gaps) > FARTHEST_S:
            raise InvalidInputError(
                f"the times of sensor {recording.sensors[k].name!r} ({start:.3f} to {end:.3f} s) "
                f"miss those of every other by {min(gaps):.3f} s or more. Were other clocks "
                "(time of day, POSIX, GPS) or other recordings meant?"
            )


def common_targets(recording: Recording) -> None:
    """Refuse a sensor whose identities no other sensor gives, where two give identities."""
    sets = {
        k: set(np.unique(recording.target[reports]).tolist()) - {UNKNOWN}
        for k, reports in _own_reports(recording).items()
    }
    given = [k for k, own in sets.items() if own]
    for k in given if len(given) > 1 else ():
        others = set().union(*(sets[j] for j in given if j != k))
        if not sets[k] & others:
            one, other = min(sets[k]), min(others)
            raise InvalidInputError(
                f"sensor {recording.sensors[k].name!r} has no target in common with another: it "
                f"has {_label(recording, one)}, others {_label(recording, other)}. Give "
                "identities that the sensors share, or leave them empty to pair by position."
            )


def _own_reports(recording: Recording) -> dict[int, IntArray]:
    """Numbers of the reports that stand alone, of each sensor that has any."""
    alone = recording.alone
    found = {
        k: np.flatnonzero(alone & (recording.sensor == k)) for k in range(len(recording.sensors))
    }
    return {k: reports for k, reports in found.items() if reports.size}


def _label(recording: Recording, target: int) -> str:
    return repr(recording.labels[target]) if target < len(recording.labels) else str(target)


def check(recording: Recording, where: Callable[[int], str] = _report) -> None:
    """Run every check.

    Parameters
    ----------
    recording : Recording
    where : callable, optional
        From the number of a report to what the reader of an error knows it by.

    Raises
    ------
    InvalidInputError
        One sensor only, a sensor without reports, duplicates, clocks that do not overlap, no
        common target where identities are given.
    """
    several_sensors(recording)
    no_duplicates(recording, where)
    clocks_overlap(recording)
    common_targets(recording)
