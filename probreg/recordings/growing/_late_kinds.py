"""Kinds of reports that appear only after the first minutes: counted, as nothing models them.

A watch cannot gain a sensor while it runs. Until their slice is cut such reports bear numbers
beyond those of the setup's sensors, the same whatever pieces they came in.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from probreg.recordings._arrivals import Arrivals, chosen
from probreg.recordings._heights import beside_kinds
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.typing import IntArray


def with_fixed(arrivals: Arrivals, setup: Setup) -> Arrivals:
    """Arrivals under a setup that has no more sensors than before."""
    if len(arrivals.setup.sensors) == len(setup.sensors):
        return arrivals
    number = _numbers(arrivals.setup, np.arange(len(arrivals.setup.sensors)) < len(setup.sensors))
    arrays = {**arrivals.arrays, "sensor": number[arrivals.arrays["sensor"]]}
    return dataclasses.replace(arrivals, setup=setup, arrays=arrays)


def settled(
    given: Setup, completed: Setup, start: Recording, rest: dict[str, Any]
) -> tuple[Setup, Recording, dict[str, Any]]:
    """A setup completed only by kinds that the first minutes have, with reports numbered by it.

    Parameters
    ----------
    given, completed : Setup
        By the user; by all that has been read, which may be more than the first minutes.
    start : Recording
        The first minutes.
    rest : dict of str to ndarray
        Arrays of what was read beyond them, empty where there is nothing.
    """
    every = np.arange(len(completed.sensors))
    kept = (every < len(given.sensors)) | np.isin(every, start.sensor)
    if kept.all():
        return completed, start, rest
    number = _numbers(completed, kept)
    sensors = tuple(completed.sensors[k] for k in np.flatnonzero(kept).tolist())
    dropped = {completed.sensors[k].name for k in np.flatnonzero(~kept).tolist()}
    biases = {name: terms for name, terms in completed.biases.items() if name not in dropped}
    setup = dataclasses.replace(completed, sensors=sensors, biases=biases)
    start = dataclasses.replace(start, sensors=sensors, sensor=number[start.sensor])
    if rest:
        rest = {**rest, "sensor": number[rest["sensor"]]}
    return setup, start, rest


def counted(arrays: dict[str, Any], num_sensors: int) -> tuple[dict[str, Any], dict[str, int]]:
    """Arrays without reports of late kinds, and how many there were of each kind."""
    late = arrays["sensor"] - num_sensors
    if (late < 0).all():
        return arrays, {}
    names = _kind_names()
    counts = np.bincount(late[late >= 0], minlength=len(names)).tolist()
    count = {name: n for name, n in zip(names, counts, strict=True) if n}
    return chosen(arrays, np.flatnonzero(late < 0)), count


def _numbers(setup: Setup, kept: np.ndarray) -> IntArray:
    """New number of each sensor: kept ones in order, others beyond them by their kind."""
    number = np.cumsum(kept) - 1
    names = _kind_names()
    for k in np.flatnonzero(~kept).tolist():
        number[k] = int(kept.sum()) + names.index(setup.sensors[k].kind.name)
    return number


def _kind_names() -> tuple[str, ...]:
    """Kinds that stand beside others: all that can appear of themselves."""
    return tuple(dict.fromkeys(owner.kind.name for owner in beside_kinds().values()))
