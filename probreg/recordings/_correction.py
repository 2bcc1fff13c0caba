"""Recordings with the biases taken out, and put back."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from probreg.recordings._bias_model import bias_model
from probreg.recordings._heights import in_order
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.sensors.terms import Term, add_terms, remove_terms
from probreg.typing import FloatArray
from probreg.validation import finite_array

_Change = Callable[[Sequence[Term], FloatArray, FloatArray], FloatArray]


def correct(recording: Recording, setup: Setup, theta: FloatArray) -> Recording:
    """The recording without biases theta (p,), in order of the corrected times.

    Reports are corrected in their own axes, each component in its own unit. Refraction, and
    what belongs to single targets, stay in them. What came beside a report moves in time with
    it.

    Raises
    ------
    InvalidInputError
        Theta of another length, or so large that it cannot be taken out.
    """
    return _ordered(recording, *corrected_values(recording, setup, theta))


def restore(recording: Recording, setup: Setup, theta: FloatArray) -> Recording:
    """The recording with biases theta (p,): the inverse of `correct`."""
    return _ordered(recording, *_changed(recording, setup, theta, add_terms, 1.0))


def corrected_values(
    recording: Recording, setup: Setup, theta: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values (n, q) and times (n,) without biases, in the order of the recording."""
    return _changed(recording, setup, theta, remove_terms, -1.0)


def _changed(
    recording: Recording, setup: Setup, theta: FloatArray, change: _Change, sign: float
) -> tuple[FloatArray, FloatArray]:
    model = bias_model(setup)
    theta = finite_array("theta", theta, (len(model.names),))
    values, time = recording.values.copy(), recording.time
    for k, (terms, columns) in enumerate(zip(model.terms, model.columns, strict=True)):
        rows, q = np.flatnonzero(recording.sensor == k), len(setup.sensors[k].bias_names)
        values[rows, :q] = change(terms, theta[columns], values[rows, :q])
    delay = np.array([model.delay(k, theta) for k in range(len(setup.sensors))])
    late = delay[recording.sensor]
    if recording.beside is not None:
        came = np.flatnonzero(~recording.alone)
        late[came] += delay[recording.sensor[recording.beside[came]]]
    return values, time + sign * late


def _ordered(recording: Recording, values: FloatArray, time: FloatArray) -> Recording:
    fields = ("sensor", "target", "own_position", "heading", "beside")
    known = {name: getattr(recording, name) for name in fields}
    arrays = {name: array for name, array in known.items() if array is not None}
    arrays |= {"values": values, "time": time}
    return dataclasses.replace(recording, **in_order(arrays, np.argsort(time, kind="stable")))
