"""What a watch says after every slice."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from probreg.typing import FloatArray, IntArray


@dataclass(frozen=True)
class Alarm:
    """Something has changed.

    Attributes
    ----------
    kind : str
        "step", "ramp", "noise" or "silence".
    sensor, term : str
        Empty where the alarm is not of one term.
    time : float
        When it is most likely to have begun, seconds.
    size, sd : float
        Of the step in the term's unit, of the ramp in it per second, of the noise as a factor;
        NaN of a silence.
    score : float
        Evidence over the threshold, above one.
    """

    kind: str
    sensor: str
    term: str
    time: float
    size: float
    sd: float
    score: float


@dataclass(frozen=True)
class Counts:
    """Reports of a slice.

    Attributes
    ----------
    used : int
        That were taken in.
    refused : int
        Of those that leave the open slices, not believed: outliers and wrong identities.
    late : int
        That came when their slice was closed.
    unplaced : int
        Without identity, or of a kind that was not there at the start.
    """

    used: int = 0
    refused: int = 0
    late: int = 0
    unplaced: int = 0


@dataclass(frozen=True, eq=False)
class SliceResult:
    """What is known at the end of a slice, SI units.

    Attributes
    ----------
    time : float
        End of the slice, seconds.
    names, units : tuple of str
    mean, sd : ndarray, shape (p,)
    constant : ndarray, shape (p,)
        Probability that each bias does not drift.
    exceeded : dict of str to float
        Probability that the limit of each bias that has one is exceeded.
    spread : ndarray, shape (p,)
        Estimated standard deviation that each bias gains in a minute.
    counts : Counts
    sensors : tuple of str
    by_sensor : ndarray of int, shape (sensors,)
        Reports used of each sensor.
    alarms : tuple of Alarm
    """

    time: float
    names: tuple[str, ...]
    units: tuple[str, ...]
    mean: FloatArray
    sd: FloatArray
    constant: FloatArray
    exceeded: dict[str, float]
    spread: FloatArray
    counts: Counts
    sensors: tuple[str, ...]
    by_sensor: IntArray
    alarms: tuple[Alarm, ...] = field(default=())

    def to_json(self) -> dict[str, Any]:
        """Plain numbers, strings, lists and dicts; None for what is not a number."""
        return {
            "time": self.time,
            "biases": {
                name: {
                    "unit": unit,
                    "mean": float(self.mean[c]),
                    "sd": float(self.sd[c]),
                    "p_constant": float(self.constant[c]),
                    "spread_per_root_minute": float(self.spread[c]),
                    **({"p_exceeded": self.exceeded[name]} if name in self.exceeded else {}),
                }
                for c, (name, unit) in enumerate(zip(self.names, self.units, strict=True))
            },
            "reports": asdict(self.counts),
            "by_sensor": dict(zip(self.sensors, self.by_sensor.tolist(), strict=True)),
            "alarms": [_plain(asdict(alarm)) for alarm in self.alarms],
        }


def _plain(given: dict[str, Any]) -> dict[str, Any]:
    def number(value: Any) -> Any:
        return None if isinstance(value, float) and not np.isfinite(value) else value

    return {key: number(value) for key, value in given.items()}
