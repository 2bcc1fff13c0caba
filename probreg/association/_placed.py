"""Reports of a recording as positions in the common frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.recordings import Recording, Setup, bias_model, corrected_values, places, turns
from probreg.sensors import Sensor, turned
from probreg.typing import FloatArray, IntArray

_NOISE_SIGMAS, _BIAS_SIGMAS = 6.0, 2.0


@dataclass(frozen=True, eq=False)
class Placed:
    """Where and when reports were made, as far as is known.

    Attributes
    ----------
    sensors : tuple of Sensor
    sensor : ndarray of int, shape (n,)
    time : ndarray, shape (n,)
    where : ndarray, shape (n, d)
        NaN for reports that place no target, such as bearings.
    gate : ndarray, shape (n,)
        How far a report of the same target may be, metres: the setup's gate, widened for
        reports that are places by six standard deviations of the noise, and by two of the
        biases where they are not known.
    reports : ndarray, shape (n, q)
        Those that place no target, corrected, with azimuths from the axes; q may be zero.
    slack : ndarray, shape (n, q, k)
        How far each unknown bias may move them.
    own : ndarray, shape (n, d)
        The platform's position.
    """

    sensors: tuple[Sensor, ...]
    sensor: IntArray
    time: FloatArray
    where: FloatArray
    gate: FloatArray
    reports: FloatArray
    slack: FloatArray
    own: FloatArray

    def misfit(self, rows: IntArray, at: FloatArray) -> FloatArray:
        """Distances (k,) of reports from targets at (k, d), in gates: below one fits."""
        away = np.linalg.norm(self.where[rows] - at, axis=1) / self.gate[rows]
        for k, sensor in enumerate(self.sensors):
            if not sensor.gives_position:
                mine = np.flatnonzero(self.sensor[rows] == k)
                away[mine] = self._across(sensor, rows[mine], at[mine])
        return away

    def _across(self, sensor: Sensor, rows: IntArray, at: FloatArray) -> FloatArray:
        """How far what reports say misses targets at (k, d): residuals over what they may be.

        What they may be is the gate, seen by the sensor, with noise and unknown biases.
        """
        q = len(sensor.bias_names)
        e, G, C, D = (
            part[:, :q] for part in sensor.observe(self.reports[rows, :q], at, self.own[rows])
        )
        left = e - np.einsum("nqd,nd->nq", G, at)
        gate = self.gate[rows, None, None] * G
        slack = D @ self.slack[rows, :q]
        limit = _NOISE_SIGMAS**2 * C[:, :, :q] + gate @ gate.mT + slack @ slack.mT
        scaled = np.linalg.solve(limit, left[..., None])[..., 0]
        return np.sqrt(np.einsum("nq,nq->n", left, scaled))


def place(recording: Recording, setup: Setup, theta: FloatArray | None) -> Placed:
    """Convert reports, corrected by theta (p,) if it is known."""
    model = bias_model(setup)
    zero = np.zeros(len(model.names))
    values, time = corrected_values(recording, setup, zero if theta is None else theta)
    turn = turns(recording, setup, np.arange(len(recording)))
    n, dim, own = len(recording), recording.sensors[0].dim, recording.own_position
    across = [k for k, sensor in enumerate(recording.sensors) if not sensor.gives_position]
    most = max((len(recording.sensors[k].bias_names) for k in across), default=0)
    terms = max((len(model.terms[k]) for k in across), default=0)
    placed = Placed(
        recording.sensors,
        recording.sensor,
        time,
        places(recording, setup, values),
        np.full(n, setup.gate_m),
        np.full((n, most), np.nan),
        np.zeros((n, most, 0 if theta is not None else terms)),
        np.zeros((n, dim)) if own is None else own,
    )
    for k, sensor in enumerate(recording.sensors):
        rows, q = np.flatnonzero(recording.sensor == k), len(sensor.bias_names)
        reports = turned(sensor, values[rows, :q], turn[rows])
        prior = model.prior_sd[model.columns[k]]
        free = model.terms[k] if theta is None else ()
        columns = [sd * t.column(reports) for t, sd in zip(free, prior[: len(free)], strict=True)]
        if not sensor.gives_position:
            placed.reports[rows, :q] = reports
            for j, column in enumerate(columns):
                placed.slack[rows, :q, j] = _BIAS_SIGMAS * column
            continue
        seen = sensor.observe(reports, placed.where[rows], placed.own[rows])
        square = _NOISE_SIGMAS**2 * np.einsum("ndd->n", seen.C)
        for column in columns:
            moved = np.einsum("ndq,nq->nd", seen.D, column)
            square = square + _BIAS_SIGMAS**2 * np.einsum("nd,nd->n", moved, moved)
        placed.gate[rows] = np.sqrt(setup.gate_m**2 + square)
    return placed
