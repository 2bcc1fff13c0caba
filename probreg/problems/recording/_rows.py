"""Which reports make a row, and why there may be none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.problems.recording._grouping import grow_rows
from probreg.recordings import Recording, Setup
from probreg.typing import FloatArray, IntArray

TOGETHER_S = 1e-3  # a target moves less than a metre in it
MOST = 6  # reports a row: in a longer one a wrong report spoils more


@dataclass(frozen=True, eq=False)
class RowPlan:
    """Reports by row; a row holds reports of one target by two sensors or more.

    Attributes
    ----------
    members : ndarray of int, shape (m,)
        Numbers of reports, row after row.
    start : ndarray of int, shape (rows + 1,)
        Where in `members` each row starts.
    moving : ndarray of int, shape (rows,)
        1 where position and velocity are eliminated, 0 where the reports are simultaneous.
    target : ndarray of int, shape (rows,)
    """

    members: IntArray
    start: IntArray
    moving: IntArray
    target: IntArray

    def __len__(self) -> int:
        return len(self.moving)

    @property
    def row(self) -> IntArray:
        """Row number of each of the members."""
        return np.repeat(np.arange(len(self)), np.diff(self.start))

    def take(self, rows: IntArray) -> RowPlan:
        """Some of the rows, in the order given."""
        length = np.diff(self.start)[rows]
        start = np.concatenate([[0], np.cumsum(length)])
        within = np.arange(start[-1]) - np.repeat(start[:-1], length)
        members = self.members[np.repeat(self.start[rows], length) + within]
        return RowPlan(members, start, self.moving[rows], self.target[rows])


def plan_rows(recording: Recording, setup: Setup, *, always_moving: bool = False) -> RowPlan:
    """Group reports of one target that follow one another within the setup's window.

    Parameters
    ----------
    recording : Recording
        With identities.
    setup : Setup
    always_moving : bool
        No row of simultaneous reports: where a clock is in question they tell no velocity.

    Raises
    ------
    InvalidInputError
        One sensor only, no target in common, no overlap in time; with numbers.
    """
    _require_common(recording)
    known = np.flatnonzero(recording.target >= 0)
    order = known[np.argsort(recording.target[known], kind="stable")]
    target, time = recording.target[order], recording.time[order]
    equations = np.array([len(s.bias_names) for s in recording.sensors])
    row, moving = grow_rows(
        np.ascontiguousarray(target, dtype=np.int64),
        time,
        np.ascontiguousarray(recording.sensor[order], dtype=np.int64),
        equations,
        dimension(recording),
        float(setup.window_s),
        -1.0 if always_moving else TOGETHER_S,
        MOST,
    )
    used = np.flatnonzero(row >= 0)
    used = used[np.argsort(row[used], kind="stable")]
    if len(moving) == 0:
        raise InvalidInputError(_no_row(recording, setup))
    start = np.searchsorted(row[used], np.arange(len(moving) + 1))
    plan = RowPlan(order[used], start, moving, target[used][start[:-1]])
    # rows of one size together: laws then compute one normaliser for many
    size = np.add.reduceat(equations[recording.sensor[plan.members]], start[:-1]) - moving
    return plan.take(np.lexsort((recording.time[plan.members[start[:-1]]], size)))


def dimension(recording: Recording) -> int:
    """Number of Cartesian coordinates that the sensors share.

    Raises
    ------
    InvalidInputError
        Sensors of different dimension.
    """
    dims = {sensor.name: sensor.dim for sensor in recording.sensors}
    if len(set(dims.values())) != 1:
        raise InvalidInputError(
            f"sensors of different dimension: {dims}. Describe all of them in 2-D or all in 3-D."
        )
    return next(iter(dims.values()))


def _require_common(recording: Recording) -> None:
    seen = [recording.sensors[k].name for k in np.unique(recording.sensor)]
    if len(seen) < 2:
        raise InvalidInputError(
            f"reports of {len(seen)} sensor(s) {seen}: a bias shows only where at least two "
            "sensors, or a sensor and a reference, report the same target."
        )
    known = recording.target >= 0
    pairs = np.unique(np.stack([recording.target[known], recording.sensor[known]]), axis=1)
    if not (np.bincount(pairs[0]) > 1).any():
        raise InvalidInputError(
            f"no target was seen by two of the sensors {seen}: {known.sum()} of {len(recording)} "
            "reports carry an identity. Check that identities are common to the sensors, or "
            "remove them and have the reports associated."
        )


def _no_row(recording: Recording, setup: Setup) -> str:
    """Why no row closed, with the window that would close one."""
    gap = _smallest_gap(recording)
    text = f"no target was reported by two sensors often enough within {setup.window_s:g} s"
    if gap > setup.window_s:
        return (
            f"{text}: their reports of a common target are {gap:.3g} s apart at least. Check that "
            "the clocks have one zero; else enlarge window_s."
        )
    return (
        f"{text}: a straight line through a target's reports needs three of them, unless they are "
        f"simultaneous within {TOGETHER_S:g} s. Enlarge window_s to twice the slowest scan."
    )


def _smallest_gap(recording: Recording) -> float:
    known = np.flatnonzero(recording.target >= 0)
    order = known[np.argsort(recording.target[known], kind="stable")]
    target, sensor = recording.target[order], recording.sensor[order]
    beside = (target[1:] == target[:-1]) & (sensor[1:] != sensor[:-1])
    gaps: FloatArray = np.diff(recording.time[order])[beside]
    return float(gaps.min(initial=np.inf))
