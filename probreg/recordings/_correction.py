"""Recordings with the biases taken out, and put back."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from probreg.recordings._bias_model import bias_model
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.sensors.terms import Term, add_terms, remove_terms
from probreg.typing import FloatArray
from probreg.validation import finite_array

_Change = Callable[[Sequence[Term], FloatArray, FloatArray], FloatArray]


def correct(recording: Recording, setup: Setup, theta: FloatArray) -> Recording:
    """The recording without biases theta (p,), in order of the corrected times.

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
    values, time = recording.values.copy(), recording.time.copy()
    for k, (terms, columns) in enumerate(zip(model.terms, model.columns, strict=True)):
        rows, q = np.flatnonzero(recording.sensor == k), len(setup.sensors[k].bias_names)
        values[rows, :q] = change(terms, theta[columns], values[rows, :q])
        time[rows] += sign * model.delay(k, theta)
    return values, time


def _ordered(recording: Recording, values: FloatArray, time: FloatArray) -> Recording:
    order = np.argsort(time, kind="stable")
    fields = ("sensor", "target", "own_position", "heading")
    beside = recording.beside
    if beside is not None:
        number = np.empty_like(order)
        number[order] = np.arange(len(order))
        beside = number[beside[order]]
    known = {name: getattr(recording, name) for name in fields}
    moved = {name: array[order] for name, array in known.items() if array is not None}
    return dataclasses.replace(
        recording, values=values[order], time=time[order], beside=beside, **moved
    )
