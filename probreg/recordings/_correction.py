"""Recordings with the biases taken out, and put back."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from probreg.recordings._bias_model import BiasModel, bias_model
from probreg.recordings._heights import in_order
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.recordings.bias_paths import Biases, BiasPaths
from probreg.sensors.terms import Term, add_terms, remove_terms
from probreg.typing import FloatArray
from probreg.validation import finite_array

_Change = Callable[[Sequence[Term], FloatArray, FloatArray], FloatArray]
_PASSES = 50  # of stamps and clocks that drift


def correct(recording: Recording, setup: Setup, theta: Biases) -> Recording:
    """The recording without biases, in order of the corrected times.

    Reports are corrected in their own axes, each component in its own unit. Refraction, and
    what belongs to single targets, stay in them. What came beside a report moves in time with
    it.

    Parameters
    ----------
    recording : Recording
    setup : Setup
    theta : ndarray, shape (p,), or BiasPaths
        Of paths every report has the values at its stamp; before the first and after the last
        time they are held.

    Raises
    ------
    InvalidInputError
        Theta of another length, or so large that it cannot be taken out.
    """
    return _ordered(recording, *corrected_values(recording, setup, theta))


def restore(recording: Recording, setup: Setup, theta: Biases) -> Recording:
    """The recording with biases theta: the inverse of `correct`."""
    time = recording.time + _late(recording, setup, theta, recording.time)
    if isinstance(theta, BiasPaths):
        # a clock that drifts was ahead by what its path has at the stamp
        for _ in range(_PASSES):
            before, time = time, recording.time + _late(recording, setup, theta, time)
            if np.array_equal(before, time):
                break
    return _ordered(recording, _changed(recording, setup, theta, time, add_terms), time)


def corrected_values(
    recording: Recording, setup: Setup, theta: Biases
) -> tuple[FloatArray, FloatArray]:
    """Values (n, q) and times (n,) without biases, in the order of the recording."""
    values = _changed(recording, setup, theta, recording.time, remove_terms)
    return values, recording.time - _late(recording, setup, theta, recording.time)


def _changed(
    recording: Recording, setup: Setup, theta: Biases, stamp: FloatArray, change: _Change
) -> FloatArray:
    model = bias_model(setup)
    values = recording.values.copy()
    for k, (terms, columns) in enumerate(zip(model.terms, model.columns, strict=True)):
        rows, q = np.flatnonzero(recording.sensor == k), len(setup.sensors[k].bias_names)
        own = _at(model, theta, stamp[rows])[columns]
        values[rows, :q] = change(terms, own, values[rows, :q])
    return values


def _at(model: BiasModel, theta: Biases, stamp: FloatArray) -> FloatArray:
    """Biases (p,), or (p, n, 1) at stamps (n,)."""
    p = len(model.names)
    if isinstance(theta, BiasPaths):
        finite_array("values of bias paths", theta.values, (None, p))
        return theta.at(stamp).T[:, :, None]
    return finite_array("theta", theta, (p,))


def _late(recording: Recording, setup: Setup, theta: Biases, stamp: FloatArray) -> FloatArray:
    """What clocks are ahead by at stamps (n,); of what came beside a report, its clock too."""
    model = bias_model(setup)
    own = _at(model, theta, stamp).reshape(len(model.names), -1)
    delay = np.empty((len(setup.sensors), len(stamp)))
    for k in range(len(setup.sensors)):
        delay[k] = model.delay(k, own)
    late = delay[recording.sensor, np.arange(len(stamp))]
    if recording.beside is not None:
        came = np.flatnonzero(~recording.alone)
        late[came] += delay[recording.sensor[recording.beside[came]], came]
    return late


def _ordered(recording: Recording, values: FloatArray, time: FloatArray) -> Recording:
    fields = ("sensor", "target", "own_position", "heading", "beside")
    known = {name: getattr(recording, name) for name in fields}
    arrays = {name: array for name, array in known.items() if array is not None}
    arrays |= {"values": values, "time": time}
    return dataclasses.replace(recording, **in_order(arrays, np.argsort(time, kind="stable")))
