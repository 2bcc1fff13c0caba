"""Reports of a slice as the track model has them, with sensor models fixed at the start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.problems.recording.models import Models, companions, models_of_kinds
from probreg.recordings import TARGET_HEIGHT_M, BiasModel, Recording, Setup, bias_model, turns
from probreg.sensors.axes import EARTH_RADIUS_M
from probreg.typing import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Scene:
    """What does not change: sensors as the track model sees them.

    Attributes
    ----------
    bias : BiasModel
    seen : Models
        Sensor models, and the constants of targets.
    dim : int
    radius_m : float
        Of the earth, infinite on a plane.
    height_m : float
        Of targets without any height.
    start_sd : tuple of float
        See `TrackModel`.
    """

    bias: BiasModel
    seen: Models
    dim: int
    radius_m: float
    height_m: float
    start_sd: tuple[float, float, float, float]

    @property
    def num_biases(self) -> int:
        """Their number p."""
        return len(self.bias.names)

    @property
    def size(self) -> int:
        """Components of a target's state."""
        return 2 * self.dim + len(self.seen.constants)

    @property
    def sensor(self) -> IntArray:
        """Sensor of each model."""
        return np.array([s for s, _ in self.seen.kinds])


def scene_of(
    setup: Setup,
    kinds: tuple[tuple[int, int], ...],
    start_sd: tuple[float, float, float, float],
) -> Scene:
    """From what a setup says and which kinds of reports there are."""
    model = bias_model(setup)
    curved = setup.dim == 3 and setup.origin is not None
    return Scene(
        model,
        models_of_kinds(setup, model, np.array(kinds)),
        setup.dim,
        EARTH_RADIUS_M if curved else np.inf,
        (setup.target_height or TARGET_HEIGHT_M)[0],
        start_sd,
    )


def kinds_of(scene: Scene, recording: Recording) -> IntArray:
    """Sensor model of each report (n,), -1 of kinds that were not there at the start."""
    number = {pair: k for k, pair in enumerate(scene.seen.kinds)}
    along = recording.sensor[companions(recording)]
    pairs = zip(recording.sensor.tolist(), along.tolist(), strict=True)
    return np.array([number.get(pair, -1) for pair in pairs], dtype=np.int64)


def labels_of(recording: Recording) -> np.ndarray:
    """Name of the identity of each report (n,), empty where it has none."""
    target = recording.target[companions(recording)]
    names = recording.labels or [f"#{k}" for k in range(int(target.max(initial=-1)) + 1)]
    return np.append(np.array(names, dtype=str), "")[target]


def platform(scene: Scene, setup: Setup, recording: Recording) -> tuple[FloatArray, FloatArray]:
    """Own positions (n, d) and turns (n,) of the platforms of reports."""
    own, n = np.zeros((len(recording), scene.dim)), len(recording)
    if recording.own_position is not None:
        own[:, : recording.own_position.shape[1]] = recording.own_position
    turn = turns(recording, setup, np.arange(n)) if setup.body_frame else np.zeros(n)
    return own, turn


def require_sensors(setup: Setup, recording: Recording) -> None:
    """Refuse recordings of other sensors."""
    if recording.sensors != setup.sensors:
        names = [[s.name for s in one.sensors] for one in (recording, setup)]
        raise InvalidInputError(f"sensors are {names[0]}, those that are watched {names[1]}.")
