"""Reports of a recording as positions in the common frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.recordings import Recording, Setup, bias_model, corrected_values, places, turns
from probreg.sensors import counter_clockwise, turned
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray, IntArray

_NOISE_SIGMAS, _BIAS_SIGMAS = 6.0, 2.0


@dataclass(frozen=True, eq=False)
class Placed:
    """Where and when reports were made, as far as is known.

    Attributes
    ----------
    time : ndarray, shape (n,)
    where : ndarray, shape (n, d)
        NaN for bearings.
    gate : ndarray, shape (n,)
        How far a report of the same target may be, metres: the setup's gate, widened by six
        standard deviations of the noise, and by two of the biases where they are not known.
    azimuth : ndarray, shape (n,)
        Of bearings, from x counter-clockwise; NaN for others.
    spread : ndarray, shape (n,)
        What widens the gate of a bearing, radians: times the distance of the target.
    own : ndarray, shape (n, d)
        The platform's position.
    """

    time: FloatArray
    where: FloatArray
    gate: FloatArray
    azimuth: FloatArray
    spread: FloatArray
    own: FloatArray

    def misfit(self, rows: IntArray, at: FloatArray) -> FloatArray:
        """Distances (k,) of reports from targets at (k, d), in gates: below one fits."""
        away = np.linalg.norm(self.where[rows] - at, axis=1) / self.gate[rows]
        bearings = np.isfinite(self.azimuth[rows])
        if bearings.any():
            rows, line = rows[bearings], (at - self.own[rows])[bearings]
            distance = np.linalg.norm(line, axis=1)
            turn = wrap_angle(self.azimuth[rows] - np.arctan2(line[:, 1], line[:, 0]))
            limit = np.hypot(self.gate[rows], self.spread[rows] * distance)
            away[bearings] = np.abs(turn) * distance / limit
        return away


def place(recording: Recording, setup: Setup, theta: FloatArray | None) -> Placed:
    """Convert reports, corrected by theta (p,) if it is known."""
    model = bias_model(setup)
    zero = np.zeros(len(model.names))
    values, time = corrected_values(recording, setup, zero if theta is None else theta)
    turn = turns(recording, setup, np.arange(len(recording)))
    n, dim = len(recording), recording.sensors[0].dim
    own = recording.own_position
    placed = Placed(
        time,
        places(recording, values, turn),
        np.full(n, setup.gate_m),
        np.full(n, np.nan),
        np.zeros(n),
        np.zeros((n, dim)) if own is None else own,
    )
    for k, sensor in enumerate(recording.sensors):
        rows = np.flatnonzero(recording.sensor == k)
        reports = turned(sensor, values[rows, : len(sensor.bias_names)], turn[rows])
        prior = model.prior_sd[model.columns[k]]
        terms = model.terms[k] if theta is None else ()
        columns = [sd * t.column(reports) for t, sd in zip(terms, prior[: len(terms)], strict=True)]
        if not sensor.gives_position:
            placed.azimuth[rows] = counter_clockwise(sensor, reports[:, 0])
            square = (_NOISE_SIGMAS * float(sensor.sigmas[0])) ** 2
            square += sum((_BIAS_SIGMAS * c[:, 0]) ** 2 for c in columns)
            placed.spread[rows] = np.sqrt(square)
            continue
        seen = sensor.observe(reports, placed.where[rows], placed.own[rows])
        square = _NOISE_SIGMAS**2 * np.einsum("ndd->n", seen.C)
        for column in columns:
            moved = np.einsum("ndq,nq->nd", seen.D, column)
            square = square + _BIAS_SIGMAS**2 * np.einsum("nd,nd->n", moved, moved)
        placed.gate[rows] = np.sqrt(setup.gate_m**2 + square)
    return placed
