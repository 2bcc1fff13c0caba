"""Reports of targets as arrays, and the equations they are near given biases and paths."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks import ScalarEquations, track_equations
from probreg.problems.recording.knots import Knots
from probreg.problems.recording.linearisation import (
    At,
    PathPoints,
    TrackLinearisation,
    Where,
    write_equations,
)
from probreg.problems.recording.sensor_model import SensorModel
from probreg.sensors.axes import fall
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import finite_array

_BLOCK = 16_384  # reports linearised at once


@dataclass(frozen=True, eq=False)
class TrackReports:
    """Reports of targets that move, as arrays.

    Parameters
    ----------
    models : tuple of SensorModel
    sensor : ndarray of int, shape (n,)
        Which model each report is of.
    target : ndarray of int, shape (n,)
        Whom it says it is of, from 0.
    time : ndarray, shape (n,)
        Its stamp, seconds.
    values : ndarray, shape (n, q)
        Components; NaN those that are missing or that the sensor does not have.
    num_biases, num_constants : int
        Of all sensors; of each target.
    dim : int
        Dimensions of the position.
    radius_m : float
        Of the earth, for the fall of level flight in a rigid frame; infinite on a plane.
    own : ndarray, shape (n, d), optional
        Where the platform of each sensor is, metres; sensors see from there.
    turn : ndarray, shape (n,), optional
        What a heading adds to the azimuth of each report, radians.
    beside : ndarray of int, shape (n,), optional
        Number of the report that each came with; its own for those that stand alone.
    knots : Knots, optional
        Where biases that drift have coefficients; by default all are constant.

    Raises
    ------
    InvalidInputError
        Arrays that do not fit; a report without any component.
    """

    models: tuple[SensorModel, ...]
    sensor: IntArray
    target: IntArray
    time: FloatArray
    values: FloatArray
    num_biases: int
    dim: int = 2
    num_constants: int = 0
    radius_m: float = np.inf
    own: FloatArray | None = None
    turn: FloatArray | None = None
    beside: IntArray | None = None
    knots: Knots | None = None

    def __post_init__(self) -> None:
        n = np.size(self.time)
        time = finite_array("time", self.time, (n,))
        values = np.asarray(self.values, dtype=float)
        whole = {name: np.asarray(getattr(self, name)) for name in ("sensor", "target")}
        for name, array in whole.items():
            if array.shape != (n,) or array.dtype.kind not in "iu" or (array < 0).any():
                raise InvalidInputError(f"{name} must be ({n},) whole numbers from 0.")
        if n == 0 or whole["sensor"].max() >= len(self.models):
            raise InvalidInputError(f"no reports, or of a sensor beyond the {len(self.models)}.")
        widest = max(len(model.sigmas) for model in self.models)
        if values.shape != (n, widest):
            raise InvalidInputError(f"values have shape {values.shape}; ({n}, {widest}) is needed.")
        mute = np.flatnonzero(~np.isfinite(values).any(axis=1))
        if mute.size:
            raise InvalidInputError(f"report {mute[0]} ({mute.size} in all) has no component.")
        columns = [c for model in self.models for c, _ in model.terms]
        own = [c for model in self.models for c, _ in model.own]
        if any(c >= self.num_biases for c in columns) or any(c >= self.num_constants for c in own):
            raise InvalidInputError("a term has a place beyond the biases or constants.")
        knots = self.knots
        if knots is None or not knots.drifting:
            knots = Knots(self.num_biases)
        if knots.num_biases != self.num_biases:
            raise InvalidInputError(f"knots of {self.num_biases} biases are needed.")
        for name, value in {**whole, "time": time, "values": values, "knots": knots}.items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.time)

    @property
    def coefficients(self) -> Knots:
        """Where the coefficients of the biases stand."""
        assert self.knots is not None
        return self.knots

    @property
    def num_targets(self) -> int:
        """Targets, named or skipped."""
        return int(self.target.max()) + 1

    @property
    def counts(self) -> IntArray:
        """Reports of each target, (targets,)."""
        return np.bincount(self.target, minlength=self.num_targets)

    def take(self, rows: IntArray, target: IntArray | None = None) -> TrackReports:
        """Some of the reports, in the order given, of targets given anew."""
        beside = self.beside
        if beside is not None:
            number = np.full(len(self), -1)
            number[rows] = np.arange(len(rows))
            beside = number[beside[rows]]
            # what a report came with may have stayed behind
            beside = np.where(beside < 0, np.arange(len(rows)), beside)
        return replace(
            self,
            sensor=self.sensor[rows],
            target=self.target[rows] if target is None else target,
            time=self.time[rows],
            values=self.values[rows],
            own=None if self.own is None else self.own[rows],
            turn=None if self.turn is None else self.turn[rows],
            beside=beside,
        )

    def reported(self, rows: IntArray) -> FloatArray:
        """Components (k, q) of reports of one sensor, azimuths from the axes of the frame."""
        model = self.models[self.sensor[rows[0]]]
        values = self.values[rows, : len(model.sigmas)]
        if self.turn is not None and model.azimuth is not None:
            values = values.copy()
            values[:, model.azimuth] += self.turn[rows]
        return values

    def shifted_time(self, theta: FloatArray) -> FloatArray:
        """Times (n,) by clocks corrected by theta."""
        late = np.zeros(len(self))
        for k, model in enumerate(self.models):
            if any(term.stamp for _, term in model.terms):
                own = np.flatnonzero(self.sensor == k)
                late[own] = self._late(model, theta, self.time[own])
        return self.time - late

    def _late(self, model: SensorModel, theta: FloatArray, stamp: FloatArray) -> FloatArray | float:
        """What a sensor's clock is ahead by at stamps (n,)."""
        value = self.coefficients.value
        return sum(term.stamp * value(theta, c, stamp) for c, term in model.terms)

    @property
    def varies(self) -> bool:
        """Whether the column of some term depends on where targets are."""
        return any(model.varies for model in self.models)

    def linearise(
        self, theta: FloatArray, path: PathPoints, steady: PathPoints | None = None
    ) -> TrackLinearisation:
        """Equations tangent at biases theta (P,) and a path.

        Columns and directions are those at the path, never at the noisy report itself: the same
        noise in both would bias the estimate. Columns of terms are those at `steady`, if given: a
        path that follows the reports less.
        """
        theta = finite_array("theta", theta, (self.coefficients.size,))
        time = self.shifted_time(theta)
        rows = np.lexsort([time, self.target])
        order = np.empty_like(rows)
        order[rows] = np.arange(len(rows))
        position = path.position + (time - path.time)[:, None] * path.velocity
        start = np.concatenate([[0], np.cumsum(self._place[rows, -1] + 1)])
        scalar = self._scalar(int(start[-1]))
        sensor = self.sensor[rows]
        for k, model in enumerate(self.models):
            of_sensor, m = np.flatnonzero(sensor == k), len(model.sigmas)
            # blocks that stay in the cache
            for low in range(0, len(of_sensor), _BLOCK):
                block = of_sensor[low : low + _BLOCK]
                own = rows[block]
                given = self.given[own, :m]
                place = start[block, None] + self._place[own, :m]
                where = Where(given, place[given], self.time[own])
                away = position[own] if self.own is None else position[own] - self.own[own]
                at = At(position[own], away, path.velocity[own])
                if steady is not None:
                    at = at._replace(steady=self._steady(steady, time, own))
                turn = None if self.turn is None else self.turn[own]
                said = self.values[own, :m], turn
                write_equations(scalar, where, model, (self.coefficients, theta), at, said)
        targets = np.bincount(self.target, minlength=self.num_targets)
        equations = track_equations(
            np.concatenate([[0], np.cumsum(targets)]),
            start,
            time[rows],
            scalar,
            self._push(rows, position, path.velocity),
        )
        return TrackLinearisation(equations, rows, order, theta)

    def _steady(
        self, steady: PathPoints, time: FloatArray, rows: IntArray
    ) -> tuple[FloatArray, FloatArray]:
        """Places of a steady path from the platform, and its velocities, for some reports."""
        velocity = steady.velocity[rows]
        away = steady.position[rows] + (time - steady.time)[rows, None] * velocity
        return (away if self.own is None else away - self.own[rows]), velocity

    @cached_property
    def given(self) -> BoolArray:
        """Which components are there, (n, q)."""
        given = np.isfinite(self.values)
        for k, model in enumerate(self.models):
            given[np.flatnonzero(self.sensor == k), len(model.sigmas) :] = False
        return given

    @cached_property
    def _place(self) -> IntArray:
        """Where the equation of each component stands among those of its report, (n, q)."""
        return np.asarray(np.cumsum(self.given, axis=1, dtype=np.int8) - 1, dtype=np.int8)

    def _scalar(self, E: int) -> ScalarEquations:
        """Room for E equations."""
        own = self.coefficients.widths
        width = max((sum(own(c) for c, _ in model.terms) for model in self.models), default=0)
        return ScalarEquations(
            np.empty(E),
            np.empty((E, self.dim)),
            np.empty(E),
            np.zeros((E, self.num_constants)),
            np.zeros((E, width), dtype=np.int64),
            np.zeros((E, width)),
        )

    def _push(
        self, rows: IntArray, position: FloatArray, velocity: FloatArray
    ) -> FloatArray | None:
        if not np.isfinite(self.radius_m):
            return None
        here = fall(position[rows], velocity[rows], self.radius_m)
        push = here.copy()
        push[1:] = 0.5 * (here[1:] + here[:-1])
        first = np.flatnonzero(np.diff(self.target[rows], prepend=-1))
        push[first] = here[first]
        return push
