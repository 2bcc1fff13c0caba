"""What each slice of a recording says of the biases: scans that any tracker can follow."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.dynamics import RandomWalk
from probreg.motion.trajectory import Trajectory
from probreg.prior import GaussianPrior
from probreg.recordings import Recording
from probreg.typing import FloatArray
from probreg.watch._advance import advance, next_slice
from probreg.watch._filters import whole_belief
from probreg.watch.results import SliceResult
from probreg.watch.state import Filters, WatchState

EDGE = 1e-9  # of a slice, by which rounding may put a stamp beyond its end
LEAST_SHARE = 1e-9  # of the most that a slice says, below which a direction is not seen


class SlicedRecording(NamedTuple):
    """A recording as a watch saw it.

    Attributes
    ----------
    model : Trajectory
        One scan a closed slice: its likelihood with paths and older biases integrated out, given
        all that came until it closed. Times are the middles of the slices.
    results : tuple of SliceResult
        What the watch said at the end of every slice.
    state : WatchState
        At the end.
    """

    model: Trajectory
    results: tuple[SliceResult, ...]
    state: WatchState


class _Told(NamedTuple):
    """Normal beliefs about the biases of one slice."""

    mean: FloatArray
    covariance: FloatArray


def sliced(state: WatchState, recording: Recording, walk: FloatArray) -> SlicedRecording:
    """Watch a recording to its end, and keep what every slice that closes says by itself.

    Parameters
    ----------
    state : WatchState
        From `begin`, with the reports up to its time.
    recording : Recording
        Reports up to the state's time are passed over.
    walk : ndarray, shape (p,)
        Standard deviation that each bias is taken to gain in a second, SI units, for the steps of
        the trajectory.

    Raises
    ------
    InvalidInputError
        Fewer than two slices after the state's time.
    """
    settings, results = state.settings, []
    told: list[tuple[_Told, _Told]] = []
    middles: list[float] = []
    last = float(recording.time[-1])
    count = int(np.ceil((last - state.time) / settings.slice_s - EDGE))
    if count < 2:
        raise InvalidInputError(
            f"the recording ends at {recording.time[-1]:g}, less than two slices after "
            f"{state.time:g}."
        )
    closing = settings.window - settings.open_slices
    # one number an edge, or a stamp on it would come twice or never
    edges = state.origin + (state.slices + np.arange(count + 1)) * settings.slice_s
    edges[-1] = max(edges[-1], last)
    for start, end in pairwise(edges.tolist()):
        begun = next_slice(state)[1]
        reports = recording.during(start, end)
        state, result = advance(state, reports if len(reports) else None, end)
        results.append(result)
        before = _at(begun, closing, state.theta)
        told.append((before, _at(state.filters, closing, state.theta)))
        middles.append(state.time - (settings.open_slices - 0.5) * settings.slice_s)
    return SlicedRecording(_trajectory(state, told, np.array(middles), walk), tuple(results), state)


def _at(filters: Filters, knot: int, theta: FloatArray) -> _Told:
    p = theta.size
    size = filters.shift.shape[1]
    mean, covariance = whole_belief(filters, np.zeros((size, size)), np.zeros(size))
    own = slice(knot * p, (knot + 1) * p)
    return _Told(theta + mean[own], covariance[own, own])


def _trajectory(
    state: WatchState, told: list[tuple[_Told, _Told]], time: FloatArray, walk: FloatArray
) -> Trajectory:
    """Scans y = H x + N(0, 1), from the difference of what is believed before and after."""
    p, first = state.theta.size, told[0][0]
    rows = [_whitened(before, after, state.scene.bias.prior_sd) for before, after in told]
    y, H, present = (np.array(part) for part in zip(*rows, strict=True))
    steps = [RandomWalk(np.square(walk)).step(p, float(dt)) for dt in np.diff(time)]
    return Trajectory(
        y=y,
        H=H,
        R=np.tile(np.eye(p), (len(time), 1, 1)),
        F=np.array([step[0] for step in steps]).reshape(-1, p, p),
        Q=np.array([step[1] for step in steps]).reshape(-1, p, p),
        prior=GaussianPrior(first.mean, first.covariance),
        time=time,
        names=state.scene.bias.names,
        units=state.scene.bias.units,
        present=present,
    )


def _whitened(
    before: _Told, after: _Told, unit: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The likelihood that leads from one belief to the other, as equations of unit variance."""
    old, new = np.linalg.inv(before.covariance), np.linalg.inv(after.covariance)
    J, eta = new - old, new @ after.mean - old @ before.mean
    values, vectors = np.linalg.eigh(J * np.outer(unit, unit))
    seen = values > LEAST_SHARE * max(float(values[-1]), np.finfo(float).tiny)
    root = np.sqrt(np.where(seen, values, 1.0))
    H = (root[:, None] * vectors.T) / unit
    y = (vectors.T @ (unit * eta)) / root
    return np.where(seen, y, 0.0), np.where(seen[:, None], H, 0.0), seen.astype(float)
