"""The registration problem of an asynchronous recording, re-linearised at the bias."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.problems.linear import LinearProblem, bias_scale
from probreg.problems.observability import Observability
from probreg.problems.recording._elimination import eliminate, fit_paths
from probreg.problems.recording._rows import RowPlan, dimension, plan_rows
from probreg.problems.recording._velocity import steady
from probreg.recordings import Recording, Setup, bias_model, turns
from probreg.sensors import Equations, turned
from probreg.sensors.terms import remove_terms
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import finite_array

_CHUNK = 20_000  # rows worked on at once
_REACH = 2.0  # windows, to the rows whose velocity is asked too
_PASSES = 2  # of the path: the second takes weights where the first went


class _Chunk(NamedTuple):
    """Reports of some rows, corrected and placed in the common frame."""

    start: IntArray
    moving: IntArray
    sensor: IntArray
    dt: FloatArray
    equations: IntArray
    corrected: FloatArray
    turn: FloatArray
    own: FloatArray


class RecordingProblem:
    """Rows of an asynchronous recording, the targets' straight paths eliminated.

    The residual at theta is what no straight path through a row's corrected reports explains.
    R holds the converted noise of the sensors and the path noise of a target whose
    acceleration is white with `acceleration_m_s2` squared per hertz. B and R are evaluated at
    the path fitted to the row (generalised least squares), whose errors do not correlate with
    the residuals; evaluated at the reports they would bias the estimate.

    Parameters
    ----------
    recording : Recording
        With identities.
    setup : Setup
    plan : RowPlan, optional
        Which reports make a row; by default `plan_rows`.

    Attributes
    ----------
    names, units : tuple of str
        "sensor.term", and "m", "rad", "s" or "m/m".
    plan : RowPlan
    size : ndarray of int, shape (n,)
        Number of real components of each row.
    time : ndarray, shape (n,)
        Of the first report of each row.

    Raises
    ------
    InvalidInputError
        Nothing in common (see `plan_rows`), unknown terms, a body-frame sensor without heading,
        sensors of setup and recording that differ.
    """

    linear = False

    def __init__(self, recording: Recording, setup: Setup, plan: RowPlan | None = None) -> None:
        if recording.sensors != setup.sensors:
            raise InvalidInputError(
                f"the setup describes the sensors {[s.name for s in setup.sensors]}, the recording "
                f"{[s.name for s in recording.sensors]}; they must be the same, in one order."
            )
        self.recording, self.setup = recording, setup
        self.model = bias_model(setup)
        self.names, self.units = self.model.names, self.model.units
        self.dim = dimension(recording)
        clocks = self.model.clocks
        self.plan = plan_rows(recording, setup, always_moving=clocks) if plan is None else plan
        self._count = np.array([len(s.bias_names) for s in recording.sensors])
        self._places = np.array([s.gives_position for s in recording.sensors])
        # bearings tell something only where the other reports have put the target
        self._passes = _PASSES if self._places.all() else _PASSES + 2
        self._turn = turns(recording, setup, self.plan.members)

    @cached_property
    def size(self) -> IntArray:
        """Number of real components of each row, shape (n,)."""
        count = self._count[self.recording.sensor[self.plan.members]]
        total = np.add.reduceat(count, self.plan.start[:-1])
        return np.asarray(total - self.dim * (1 + self.plan.moving))

    @property
    def metric(self) -> BoolArray:
        """Whether all reports of a row are positions, and its residuals metres, shape (n,)."""
        places = self._places[self.recording.sensor[self.plan.members]]
        return np.asarray(np.logical_and.reduceat(places, self.plan.start[:-1]))

    @property
    def time(self) -> FloatArray:
        """Time of the first report of each row, shape (n,)."""
        return np.asarray(self.recording.time[self.plan.members[self.plan.start[:-1]]])

    @property
    def start(self) -> FloatArray:
        """Zero bias, shape (p,)."""
        return np.zeros(len(self.names))

    @property
    def scale(self) -> FloatArray:
        """About one metre at a target for each bias, shape (p,)."""
        return bias_scale(self.units)

    @property
    def prior_sd(self) -> FloatArray:
        """What the setup says, else what such sensors are found to have, shape (p,)."""
        return self.model.prior_sd

    @property
    def exact(self) -> None:
        """None: R changes with theta, so densities use the linear form at the mode."""
        return

    def shifted(self, row: int, component: int, by: float) -> RecordingProblem:
        """The same problem with one component of one report of a row moved.

        Components count through the reports of the row in order of time.
        """
        members = self.plan.members[self.plan.start[row] : self.plan.start[row + 1]]
        ends = np.cumsum(self._count[self.recording.sensor[members]])
        which = int(np.searchsorted(ends, component, side="right"))
        values = self.recording.values.copy()
        own = component - int(ends[which]) + self._count[self.recording.sensor[members[which]]]
        values[members[which], own] += by
        moved = dataclasses.replace(self.recording, values=values)
        return RecordingProblem(moved, self.setup, self.plan)

    def take(self, rows: IntArray) -> RecordingProblem:
        """The problem of some of the rows."""
        return RecordingProblem(self.recording, self.setup, self.plan.take(rows))

    def residual(self, theta: FloatArray) -> FloatArray:
        """What no straight path explains, shape (n, M), metres."""
        return self.linearise(theta).residual(theta)

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Derivative of the residuals, -B at the fitted paths, shape (n, M, p)."""
        return -self.linearise(theta).B

    def linearise(self, theta: FloatArray) -> LinearProblem:
        """The linear problem tangent at theta: y = residual + B theta."""
        theta = finite_array("theta", theta, (len(self.names),))
        n, M, p = len(self.plan), int(self.size.max()), len(self.names)
        y, B, R = np.zeros((n, M)), np.zeros((n, M, p)), np.zeros((n, M, M))
        R[:] = np.eye(M)
        velocity = self._velocities(theta) if self.model.clocks else None
        for a in range(0, n, _CHUNK):
            b = min(a + _CHUNK, n)
            self._fill(a, b, theta, velocity, y[a:b], B[a:b], R[a:b])
        y += B @ theta
        return LinearProblem(y, B, R, self.time, self.names, self.units, self.size)

    def observability(self, theta: FloatArray | None = None) -> Observability:
        """Singular values and unobservable combinations at theta (by default zero)."""
        return self.linearise(self.start if theta is None else theta).observability()

    # -- details -----------------------------------------------------------------------

    @property
    def _psd(self) -> float:
        return float(self.setup.acceleration_m_s2**2)

    def _fill(
        self,
        a: int,
        b: int,
        theta: FloatArray,
        velocity: FloatArray | None,
        y: FloatArray,
        B: FloatArray,
        R: FloatArray,
    ) -> None:
        """Rows a to b of the linear problem."""
        chunk = self._chunk(a, b, theta)
        where, speed, seen = self._fit(a, chunk)
        if velocity is not None:
            speed = np.repeat(velocity[a:b], np.diff(chunk.start), axis=0)
        S, columns = self._sensitivity(chunk, seen, where, speed)
        rows = (chunk.start, chunk.moving, chunk.dt, chunk.equations)
        eliminate(*rows, seen.e, seen.G, seen.C, S, columns, self._psd, y, B, R)

    def _fit(self, a: int, chunk: _Chunk) -> tuple[FloatArray, FloatArray, Equations]:
        """Position and velocity by report on the fitted lines, and the equations there."""
        rows = (chunk.start, chunk.moving, chunk.dt)
        seen = self._observe(chunk, None)
        placing = np.where(self._places[chunk.sensor], chunk.equations, 0)
        for k in range(self._passes):
            count = chunk.equations if k else placing
            where, speed = fit_paths(*rows, count, seen.e, seen.G, seen.C, self._psd)
            bad = np.flatnonzero(~np.isfinite(where).all(axis=1))
            if bad.size:
                names = [s.name for s in self.recording.sensors]
                raise InvalidInputError(
                    f"the covariance of report {self.plan.members[self.plan.start[a] + bad[0]]} is "
                    f"numerically singular. Check the accuracies of the sensors {names}: metres "
                    "and radians?"
                )
            seen = self._observe(chunk, where)
        return where, speed, seen

    def _velocities(self, theta: FloatArray) -> FloatArray:
        """Velocity of every row (n, d), from its neighbours too."""
        n = len(self.plan)
        velocity, weight = np.zeros((n, self.dim)), np.zeros(n)
        for a in range(0, n, _CHUNK):
            b = min(a + _CHUNK, n)
            chunk = self._chunk(a, b, theta)
            _, speed, _ = self._fit(a, chunk)
            velocity[a:b] = speed[chunk.start[:-1]]
            weight[a:b] = np.add.reduceat(chunk.dt**2, chunk.start[:-1])
        order = np.lexsort((self.time, self.plan.target))
        target = np.ascontiguousarray(self.plan.target[order], dtype=np.int64)
        reach = _REACH * self.setup.window_s
        velocity[order] = steady(target, self.time[order], velocity[order], weight[order], reach)
        return velocity

    def _chunk(self, a: int, b: int, theta: FloatArray) -> _Chunk:
        start = self.plan.start[a : b + 1]
        members = self.plan.members[start[0] : start[-1]]
        sensor, values = self.recording.sensor[members], self.recording.values[members]
        time = self.recording.time[members]
        corrected = values.copy()
        for k in np.unique(sensor):
            own, q = np.flatnonzero(sensor == k), self._count[k]
            coefficients = theta[self.model.columns[k]]
            corrected[own, :q] = remove_terms(self.model.terms[k], coefficients, values[own, :q])
            time[own] -= self.model.delay(k, theta)
        start = start - start[0]
        length = np.diff(start)
        centre = np.add.reduceat(time, start[:-1]) / length
        own_position = self.recording.own_position
        placed = (
            np.zeros((len(members), self.dim)) if own_position is None else (own_position[members])
        )
        turn = self._turn[self.plan.start[a] : self.plan.start[b]]
        return _Chunk(
            start,
            self.plan.moving[a:b],
            sensor,
            time - np.repeat(centre, length),
            self._count[sensor],
            corrected,
            turn,
            placed,
        )

    def _observe(self, chunk: _Chunk, where: FloatArray | None) -> Equations:
        """Equations of every report, B and R where the targets are (at first: reported)."""
        n, d = len(chunk.sensor), self.dim
        parts = Equations(np.zeros((n, d)), *(np.zeros((n, d, d)) for _ in range(3)))
        for k in np.unique(chunk.sensor):
            sensor, own = self.recording.sensors[k], np.flatnonzero(chunk.sensor == k)
            reports = turned(sensor, chunk.corrected[own, : self._count[k]], chunk.turn[own])
            at = None if where is None else where[own]
            seen = sensor.observe(reports, at, chunk.own[own])
            parts.e[own], parts.G[own], parts.C[own] = seen.e, seen.G, seen.C
            parts.D[own, :, : self._count[k]] = seen.D
        return parts

    def _sensitivity(
        self, chunk: _Chunk, seen: Equations, where: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, IntArray]:
        """Derivative of the equations by each sensor's own unknowns, and which those are."""
        most = max(len(columns) for columns in self.model.columns)
        n = len(chunk.sensor)
        S, columns = np.zeros((n, self.dim, most)), np.full((n, most), -1)
        for k in np.unique(chunk.sensor):
            sensor, own = self.recording.sensors[k], np.flatnonzero(chunk.sensor == k)
            true = sensor.to_report(where[own], chunk.own[own])
            true = turned(sensor, true, -chunk.turn[own])
            D = seen.D[own, :, : self._count[k]]
            columns[own, : len(self.model.columns[k])] = self.model.columns[k]
            for j, term in enumerate(self.model.terms[k]):
                S[own, :, j] = np.einsum("ndq,nq->nd", D, term.column(true))
                if term.stamp:
                    moved = np.einsum("nij,nj->ni", seen.G[own], velocity[own])
                    S[own, :, j] -= term.stamp * moved
        return S, columns
