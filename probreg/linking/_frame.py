"""Reports of a recording as positions in the common frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.multisensor import bias_model, corrected_values
from probreg.recordings import Recording, Setup
from probreg.typing import FloatArray


@dataclass(frozen=True, eq=False)
class Placed:
    """Where and when reports were made, as far as is known.

    Attributes
    ----------
    time : ndarray, shape (n,)
    where : ndarray, shape (n, d)
    gate : ndarray, shape (n,)
        How far a report of the same target may be, metres: the setup's gate, widened by six
        standard deviations of the noise, and by two of the biases where they are not known.
    """

    time: FloatArray
    where: FloatArray
    gate: FloatArray


_NOISE_SIGMAS, _BIAS_SIGMAS = 6.0, 2.0


def place(recording: Recording, setup: Setup, theta: FloatArray | None) -> Placed:
    """Convert reports, corrected by theta (p,) if it is known."""
    model = bias_model(setup)
    zero = np.zeros(len(model.names))
    values, time = corrected_values(recording, setup, zero if theta is None else theta)
    where = np.zeros((len(recording), recording.sensors[0].dim))
    gate = np.full(len(recording), setup.gate_m**2)
    for k, sensor in enumerate(recording.sensors):
        rows = np.flatnonzero(recording.sensor == k)
        reports = values[rows, : len(sensor.bias_names)]
        local = sensor.to_cartesian(reports)
        where[rows] = local
        gate[rows] += _NOISE_SIGMAS**2 * np.einsum("ndd->n", sensor.covariance(local))
        if theta is None:
            slope = sensor.sensitivity(local)
            for term, sd in zip(model.terms[k], model.prior_sd[model.columns[k]], strict=True):
                moved = np.einsum("ndq,nq->nd", slope, sd * term.column(reports))
                gate[rows] += _BIAS_SIGMAS**2 * np.einsum("nd,nd->n", moved, moved)
    if recording.own_position is not None:
        where += recording.own_position
    return Placed(time, where, np.sqrt(gate))
