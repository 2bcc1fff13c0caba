"""What a watch has said so far, thinned with age so that it stays bounded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from probreg.typing import FloatArray

MOST = 720  # slices that are kept: the newer half at most twice as far apart as they came
ALARMS = 200


@dataclass(frozen=True, eq=False)
class History:
    """Posterior of each bias over time.

    Attributes
    ----------
    names, units : tuple of str
    time : ndarray, shape (n,)
    mean, sd : ndarray, shape (n, p)
    exceeded : ndarray, shape (n, p)
        Probability that the limit is exceeded; NaN where there is none.
    alarms : tuple of mapping
        The latest, as the journal has them.
    """

    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    time: FloatArray = field(default_factory=lambda: np.zeros(0))
    mean: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    sd: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    exceeded: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    alarms: tuple[Mapping[str, Any], ...] = ()

    def __len__(self) -> int:
        return len(self.time)


def with_line(history: History, line: Mapping[str, Any]) -> History:
    """The history with one more line of the journal."""
    biases = line["biases"]
    names = tuple(biases)
    rows = {
        key: np.array([[_number(biases[name].get(key)) for name in names]])
        for key in ("mean", "sd", "p_exceeded")
    }
    old = history if len(history) else None
    grown = History(
        names,
        tuple(biases[name]["unit"] for name in names),
        np.append(history.time, line["time"]),
        rows["mean"] if old is None else np.concatenate([old.mean, rows["mean"]]),
        rows["sd"] if old is None else np.concatenate([old.sd, rows["sd"]]),
        rows["p_exceeded"] if old is None else np.concatenate([old.exceeded, rows["p_exceeded"]]),
        (*history.alarms, *line["alarms"])[-ALARMS:],
    )
    return _thinned(grown) if len(grown) > MOST else grown


def _number(value: float | None) -> float:
    return float("nan") if value is None else value


def _thinned(history: History) -> History:
    """Every second one of the older half."""
    half = len(history) // 2
    kept = np.concatenate([np.arange(0, half, 2), np.arange(half, len(history))])
    return History(
        history.names,
        history.units,
        history.time[kept],
        history.mean[kept],
        history.sd[kept],
        history.exceeded[kept],
        history.alarms,
    )


def to_arrays(history: History) -> dict[str, Any]:
    """Arrays of a history; its alarms are words."""
    return {
        "names": np.array(history.names, dtype=str),
        "units": np.array(history.units, dtype=str),
        **{name: getattr(history, name) for name in ("time", "mean", "sd", "exceeded")},
    }


def from_arrays(arrays: Mapping[str, Any], alarms: tuple[Mapping[str, Any], ...]) -> History:
    """The history that `to_arrays` gave."""
    names, units = (tuple(arrays[key].tolist()) for key in ("names", "units"))
    columns = {key: arrays[key] for key in ("time", "mean", "sd", "exceeded")}
    return History(names, units, **columns, alarms=alarms)
