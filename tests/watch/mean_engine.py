"""A stand-in for what computes: the mean and number of each sensor's ranges, in order."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from probreg.recordings import bias_model

WEIGHT = 0.01


@dataclass(frozen=True)
class MeanSettings:
    slice_s: float = 10.0
    delay_s: float = 20.0


@dataclass(frozen=True, eq=False)
class MeanState:
    time: float
    names: tuple
    settings: MeanSettings
    mean: np.ndarray
    sd: np.ndarray
    count: int


class Result:
    def __init__(self, state, reports):
        self.state, self.reports = state, reports

    def to_json(self):
        alarms = []
        if self.reports is not None and (self.reports.values[:, 0] > 9e5).any():
            alarms = [{"kind": "step", "sensor": self.reports.sensors[0].name, "term": "range",
                       "time": self.state.time, "size": 1.0, "sd": 0.1, "score": 2.0}]  # fmt: skip
        return {
            "time": self.state.time,
            "biases": {
                name: {"unit": "m", "mean": m, "sd": s, "p_exceeded": min(1.0, abs(m) / 1e5)}
                for name, m, s in zip(
                    self.state.names, self.state.mean.tolist(), self.state.sd.tolist(), strict=True
                )
            },
            "reports": {"used": 0 if self.reports is None else len(self.reports)},
            "labels": [] if self.reports is None else list(self.reports.labels),
            "alarms": alarms,
        }


def _taken(state, reports, until):
    mean = state.mean.copy()
    for k, value in zip(reports.target, reports.values[:, 0], strict=True) if reports else ():
        at = hash_of(reports.labels[k]) % len(mean)
        mean[at] += WEIGHT * (value - mean[at])
    n = 0 if reports is None else len(reports)
    return replace(
        state, time=until, mean=mean, sd=state.sd * 0.999 + 1e-3 / (1 + n), count=state.count + n
    )


def hash_of(label):
    return sum(map(ord, label))


def begin(recording, setup, settings, rng):
    names = bias_model(setup).names
    start = recording.time[0]
    slices = np.ceil((recording.time[-1] - start) / settings.slice_s)
    state = MeanState(start, names, settings, rng.normal(size=len(names)), np.ones(len(names)), 0)
    return _taken(state, recording, float(start + slices * settings.slice_s))


def advance(state, reports, until):
    assert abs(until - state.time - state.settings.slice_s) < 1e-6
    assert reports is None or reports.time[-1] <= until
    state = _taken(state, reports, until)
    return state, Result(state, reports)


def to_arrays(state):
    return {
        "time": np.array(state.time), "names": np.array(state.names),
        "mean": state.mean, "sd": state.sd, "count": np.array(state.count),
    }  # fmt: skip


def from_arrays(arrays, setup, settings):
    return MeanState(
        float(arrays["time"]), tuple(arrays["names"].tolist()), settings, arrays["mean"],
        arrays["sd"], int(arrays["count"]),
    )  # fmt: skip
