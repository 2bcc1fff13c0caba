"""Reports of a recording as positions in the common frame, and how far they may be off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from probreg.association._intervals import comparison_window, usual_intervals
from probreg.association._spots import Spots
from probreg.recordings import (
    Biases,
    Recording,
    Setup,
    bias_model,
    corrected_values,
    observing_axes,
    places,
    turns,
)
from probreg.sensors import Sensor, turned
from probreg.sensors.axes import Axes, Observed
from probreg.sensors.geometry import wrap_angle
from probreg.typing import BoolArray, FloatArray, IntArray

_NOISE_SIGMAS, _BIAS_SIGMAS = 6.0, 2.0
_ROOM_M = 300.0  # half of what geometric and barometric heights of one target may differ
_NOTHING_M = 1e-6
_GUESS_M = 5_000.0  # how far a height that nothing tells may be from the one guessed


@dataclass(frozen=True, eq=False)
class Placed:
    """Where and when reports were made, as far as is known.

    Attributes
    ----------
    sensors : tuple of Sensor
    axes : tuple of Axes
        Of the sensors, in the common frame.
    sensor : ndarray of int, shape (n,)
    time : ndarray, shape (n,)
    spots : Spots
        NaN for reports that place no target, such as bearings.
    gate : ndarray, shape (n,)
        How far a report of the same target may be, metres, horizontally: the setup's gate,
        widened for reports that are places by six standard deviations of the noise, by two of
        the biases where they are not known, and by what a guessed height makes of a slant range.
    judged : ndarray of bool, shape (n,)
        Whether a report has an identity of its own: heights have that of the report they came
        with.
    intervals : ndarray, shape (sensors,)
        See `usual_intervals`.
    reports : ndarray, shape (n, q)
        Those that place no target, corrected, with azimuths from the axes; q may be zero.
    slack : ndarray, shape (n, q, k)
        How far each unknown bias may move them.
    own : ndarray, shape (n, d)
        The platform's position.
    """

    sensors: tuple[Sensor, ...]
    axes: tuple[Axes, ...]
    sensor: IntArray
    time: FloatArray
    spots: Spots
    gate: FloatArray
    judged: BoolArray
    intervals: FloatArray
    reports: FloatArray
    slack: FloatArray
    own: FloatArray

    @property
    def window(self) -> float:
        """Longest time between reports that are compared, seconds."""
        return comparison_window(self.intervals)

    def misfit(self, rows: IntArray, at: Spots) -> FloatArray:
        """Distances (k,) of reports from targets at k spots, in gates: below one fits."""
        own = self.spots.take(rows)
        away = own.away(at) / self.gate[rows]
        away[own.elsewhere(at)] = np.inf
        for k, sensor in enumerate(self.sensors):
            if not sensor.gives_position:
                mine = np.flatnonzero(self.judged[rows] & (self.sensor[rows] == k))
                if mine.size:
                    away[mine] = self._across(k, rows[mine], at.take(mine))
        return away

    def _across(self, k: int, rows: IntArray, at: Spots) -> FloatArray:
        """How far what reports say misses targets: residuals over what they may be.

        What they may be is the gate, seen by the sensor, with noise and unknown biases.
        """
        q = len(self.sensors[k].bias_names)
        seen = self.axes[k].observe(at.where - self.own[rows])
        off = self.reports[rows, :q] - seen.value
        angles = self.axes[k].angles
        off[:, angles] = wrap_angle(off[:, angles])
        left = seen.factor * off
        reach = np.repeat(self.gate[rows, None], at.where.shape[1], axis=1)
        reach[np.isnan(at.height), 2:] = _GUESS_M
        seen_gate = seen.gradient * reach[:, None]
        slack = seen.factor[..., None] * self.slack[rows, :q]
        noise = (_NOISE_SIGMAS * _metres(self.sensors[k], seen)) ** 2
        noise = noise + _NOTHING_M**2  # what says nothing has neither noise nor gradient
        limit = noise[..., None] * np.eye(q) + seen_gate @ seen_gate.mT + slack @ slack.mT
        scaled = np.linalg.solve(limit, left[..., None])[..., 0]
        return np.sqrt(np.einsum("nq,nq->n", left, scaled))


def place(recording: Recording, setup: Setup, theta: Biases | None) -> Placed:
    """Convert reports, corrected by theta if it is known."""
    model = bias_model(setup)
    zero = np.zeros(len(model.names))
    values, time = corrected_values(recording, setup, zero if theta is None else theta)
    turn = turns(recording, setup, np.arange(len(recording)))
    said = []
    for k, sensor in enumerate(recording.sensors):
        rows = np.flatnonzero(recording.sensor == k)
        reports = turned(sensor, values[rows, : len(sensor.bias_names)], turn[rows])
        free = model.terms[k] if theta is None else ()
        prior = model.prior_sd[model.columns[k][: len(free)]]
        unknown = [
            _BIAS_SIGMAS * sd * term.column(reports) for term, sd in zip(free, prior, strict=True)
        ]
        said.append(_Said(sensor, rows, reports, unknown))
    axes = observing_axes(setup)
    where = places(recording, setup, values)
    own = np.zeros_like(where)
    if recording.own_position is not None:
        shared = min(where.shape[1], recording.own_position.shape[1])
        own[:, :shared] = recording.own_position[:, :shared]
    alone = np.ones(len(where), dtype=bool)
    if recording.beside is not None:
        alone = recording.beside == np.arange(len(where))
    mute = [k for k, ax in enumerate(axes) if ax.vertical.all()]
    across = [
        said[k] for k, s in enumerate(recording.sensors) if not (s.gives_position or k in mute)
    ]
    reports, slack = _across(across, len(where))
    spots, gate = _reach(said, axes, where, own, _beside(recording, [said[k] for k in mute]))
    return Placed(
        recording.sensors,
        axes,
        recording.sensor,
        time,
        spots,
        np.hypot(setup.gate_m, gate),
        alone & ~np.isin(recording.sensor, mute),
        usual_intervals(recording, setup, where),
        reports,
        slack,
        own,
    )


class _Said(NamedTuple):
    """Reports (m, q) of one sensor, and how far each unknown bias may move them."""

    sensor: Sensor
    rows: IntArray
    reports: FloatArray
    unknown: list[FloatArray]


def _across(said: Sequence[_Said], n: int) -> tuple[FloatArray, FloatArray]:
    """Reports (n, q) that place no target, and what unknown biases do to them (n, q, k)."""
    q = max((own.reports.shape[1] for own in said), default=0)
    reports = np.full((n, q), np.nan)
    slack = np.zeros((n, q, max((len(own.unknown) for own in said), default=0)))
    for own in said:
        reports[own.rows, : own.reports.shape[1]] = own.reports
        for j, column in enumerate(own.unknown):
            slack[own.rows, : column.shape[1], j] = column
    return reports, slack


def _beside(recording: Recording, said: Sequence[_Said]) -> FloatArray:
    """How far the heights that came with reports may be off (n,), NaN where none came."""
    found = np.full(len(recording), np.nan)
    for own in said:
        square = (_NOISE_SIGMAS * own.sensor.sigmas[0]) ** 2 + sum(
            c[:, 0] ** 2 for c in own.unknown
        )
        if recording.beside is not None:
            found[recording.beside[own.rows]] = np.sqrt(square)
    return found


def _reach(
    said: Sequence[_Said],
    axes: Sequence[Axes],
    where: FloatArray,
    own: FloatArray,
    beside: FloatArray,
) -> tuple[Spots, FloatArray]:
    """Spots, and how far (n,) noise, unknown biases and guessed heights may move them."""
    n, d = where.shape
    reach, height, room = np.zeros(n), np.full(n, np.nan), np.full(n, np.nan)
    for one, ax in zip(said, axes, strict=True):
        rows = one.rows
        if not one.sensor.gives_position or not rows.size:
            continue
        local = where[rows] - own[rows]
        itself = np.isfinite(one.reports[:, ax.vertical]).any(axis=1)
        told = itself | np.isfinite(beside[rows]) | (d == 2)
        local[~told, 2:] += 0.5 * _GUESS_M  # half way to where it might be
        seen = ax.observe(local)
        square = _squares(one, seen)
        if d == 3:
            up = np.where(itself, np.sqrt(square[:, 2]), beside[rows])
            height[rows[told]] = where[rows[told], 2]
            room[rows] = _ROOM_M + up
            square[~told, 0] += _guessed(seen.gradient[~told][:, ~ax.vertical]) ** 2
        reach[rows] = np.sqrt(square[:, 0] + square[:, 1])
    return Spots(where, height, room), reach


def _squares(one: _Said, seen: Observed) -> FloatArray:
    """Squares (m, d) of how far noise and unknown biases may move places along the axes."""
    noise = (_NOISE_SIGMAS * _metres(one.sensor, seen)) ** 2
    square: FloatArray = np.einsum("nq,nqd->nd", noise, seen.gradient**2)
    for column in one.unknown:
        moved = np.nan_to_num(seen.factor * column)  # NaN in a component that is missing
        square += np.einsum("nq,nqd->nd", moved, seen.gradient) ** 2
    return square


def _metres(sensor: Sensor, seen: Observed) -> FloatArray:
    """Standard deviations (n, q) of the components in metres; some kinds declare them so."""
    angular = [not sensor.kind.sigma_key(j).endswith("_m") for j in range(len(sensor.sigmas))]
    return sensor.sigmas * np.where(angular, seen.factor, 1.0)


def _guessed(gradient: FloatArray) -> FloatArray:
    """How far (m,) a height wrongly guessed moves places horizontally: by h dh / r for radars."""
    level, up = gradient[..., :2], gradient[..., 2]
    # rows of the gradient are orthogonal, nearly so horizontally
    share = up / np.maximum(np.einsum("nqd,nqd->nq", level, level), 1e-12)
    moved = np.einsum("nq,nqd->nd", share, level)
    found: FloatArray = _GUESS_M * np.minimum(np.linalg.norm(moved, axis=1), 1.0)
    return found
