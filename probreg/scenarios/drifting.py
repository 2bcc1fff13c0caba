"""Air traffic whose radars have biases that move: a walk, a step, a ramp, or none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import Recording, Setup
from probreg.scenarios.traffic import TrafficScene, TrafficTruth
from probreg.scenarios.traffic import simulate as simulate_traffic
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_number

GRID_S = 1.0  # between the instants at which a walk is drawn


class Drift(Protocol):
    """What is added to a bias over time."""

    def draw(self, time: FloatArray, rng: np.random.Generator) -> FloatArray:
        """The addition (n,) at times (n,) in ascending order, seconds from the start."""


@dataclass(frozen=True)
class Walk:
    """A random walk from zero.

    Parameters
    ----------
    per_root_minute : float
        Standard deviation gained in a minute, SI units of the bias.
    """

    per_root_minute: float

    def __post_init__(self) -> None:
        positive_number("per_root_minute", self.per_root_minute)

    def draw(self, time: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Exact at every time."""
        variance = np.diff(time, prepend=0.0) / 60.0 * self.per_root_minute**2
        return np.cumsum(np.sqrt(variance) * rng.standard_normal(len(time)))


@dataclass(frozen=True)
class Step:
    """A jump.

    Parameters
    ----------
    at_s, size : float
        When, seconds from the start, and how far, SI units of the bias.
    """

    at_s: float
    size: float

    def draw(self, time: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Zero before, `size` from then on."""
        return np.where(time >= self.at_s, self.size, 0.0)


@dataclass(frozen=True)
class Ramp:
    """A steady change.

    Parameters
    ----------
    at_s, per_hour : float
        When it begins, seconds from the start, and SI units of the bias gained in an hour.
    """

    at_s: float
    per_hour: float

    def draw(self, time: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Zero before, then in proportion to the time."""
        return np.maximum(time - self.at_s, 0.0) / 3_600.0 * self.per_hour


@dataclass(frozen=True, eq=False)
class DriftingScene:
    """Traffic, and which biases move how.

    Parameters
    ----------
    traffic : TrafficScene
        Its biases are those at the start.
    drift : mapping of str to Drift
        By name of a report's component, such as "radar1.azimuth".

    Raises
    ------
    InvalidInputError
        A name that is no component of a report.
    """

    traffic: TrafficScene = field(default_factory=TrafficScene)
    drift: Mapping[str, Drift] = field(default_factory=dict)

    def __post_init__(self) -> None:
        known = {f"{s.name}.{term}" for s in self.traffic.sensors for term in s.bias_names}
        strange = sorted(set(self.drift) - known)
        if strange:
            raise InvalidInputError(f"no components {strange}; known: {sorted(known)}.")


@dataclass(frozen=True, eq=False)
class DriftingTruth:
    """Ground truth, hidden from the estimators.

    Attributes
    ----------
    traffic : TrafficTruth
        Its biases are those at the start.
    time : ndarray, shape (T,)
        Every second of the recording.
    drift : dict of str to ndarray, shape (T,)
        What was added by then, by name.
    """

    traffic: TrafficTruth
    time: FloatArray
    drift: dict[str, FloatArray]

    def bias(self, name: str, time: FloatArray) -> FloatArray:
        """A bias (n,) at times (n,); between seconds on the straight line."""
        time = finite_array("time", time, (None,))
        moved = self.drift.get(name, np.zeros(len(self.time)))
        return np.asarray(self.traffic.bias[name] + np.interp(time, self.time, moved))


def simulate(
    scene: DriftingScene, rng: np.random.Generator
) -> tuple[Recording, Setup, DriftingTruth]:
    """Draw traffic, and move the biases at the true time of each report."""
    recording, setup, truth = simulate_traffic(scene.traffic, rng)
    grid = np.arange(0.0, truth.time.max() + 2.0 * GRID_S, GRID_S)
    values, drawn = recording.values.copy(), {}
    # one time line of both: the path at the reports is that on the grid
    time, where = np.unique(np.concatenate([grid, truth.time]), return_inverse=True)
    for name, drift in scene.drift.items():
        path = drift.draw(time, rng)
        drawn[name] = path[where[: len(grid)]]
        owner, term = name.rsplit(".", 1)
        k = next(k for k, s in enumerate(recording.sensors) if s.name == owner)
        sensor = recording.sensors[k]
        rows, column = np.flatnonzero(recording.sensor == k), sensor.bias_names.index(term)
        values[rows, column] += path[where[len(grid) :]][rows]
        if term == "azimuth":
            values[rows, column] = wrap_angle(values[rows, column])
    moved = replace(recording, values=values)
    return moved, setup, DriftingTruth(truth, grid, drawn)
