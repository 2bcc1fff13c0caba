"""Clocks that jump: a sensor most of whose time stamps are far ahead or far behind."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from probreg.recordings import Setup
from probreg.recordings.growing import Slice
from probreg.typing import FloatArray

FEWEST = 3  # reports of which one may speak


class Clocks(NamedTuple):
    """What a slice says of clocks.

    Attributes
    ----------
    wrong : tuple of str
        Sensors whose clocks are wrong now.
    alarms : tuple of dict
        Of those that were not before.
    """

    wrong: tuple[str, ...]
    alarms: tuple[dict[str, Any], ...]


def judge(found: Slice, setup: Setup, late_s: float, before: tuple[str, ...]) -> Clocks:
    """Sensors that give more time stamps out of range than in it.

    Parameters
    ----------
    found : Slice
    setup : Setup
    late_s : float
        Before the end of the slice, older reports can no longer be used.
    before : tuple of str
        Sensors whose clocks were wrong already: those that send nothing stay so.
    """
    wrong, alarms = [], []
    for k, sensor in enumerate(setup.sensors):
        off, good = _off(found, k, late_s)
        if not len(off) + good and sensor.name in before:
            wrong.append(sensor.name)
        if len(off) < FEWEST or len(off) <= good:
            continue
        wrong.append(sensor.name)
        if sensor.name not in before:
            size, spread = float(np.median(off)), float(np.std(off))
            alarms.append(
                {
                    "kind": "clock",
                    "sensor": sensor.name,
                    "term": "",
                    "time": found.until,
                    "size": size,
                    "sd": spread,
                    "score": float(len(off)),
                }
            )
    return Clocks(tuple(wrong), tuple(alarms))


def _off(found: Slice, sensor: int, late_s: float) -> tuple[FloatArray, int]:
    """By how much each report out of range is off, and the number of those in it."""
    ahead = found.ahead.by[found.ahead.sensor == sensor]
    if found.reports is None:
        return ahead, 0
    behind = found.reports.time[found.reports.sensor == sensor] - found.until
    late = behind < -late_s
    return np.concatenate([ahead, behind[late]]), int((~late).sum())
