"""Rows grown greedily in time over the reports of one target after another."""

from __future__ import annotations

import numba
import numpy as np

from probreg.typing import FloatArray, IntArray


@numba.njit(cache=True)
def grow_rows(
    target: IntArray,
    time: FloatArray,
    sensor: IntArray,
    equations: IntArray,
    dim: int,
    window: float,
    together: float,
    most: int,
) -> tuple[IntArray, IntArray]:
    """Row number of each report, -1 for none, and of each row whether its target moves.

    A row closes as soon as the sensor of its first report comes again with another in between,
    so that velocity is told by one sensor and its bias drops out of it. Reports within
    `together` seconds make a row at rest, unless another sensor follows before theirs.

    Parameters
    ----------
    target, time, sensor : ndarray, shape (n,)
        Sorted by target, then time.
    equations : ndarray of int
        That a report of each sensor gives.
    dim : int
    window : float
        Longest row, seconds.
    together : float
        Below zero: no row is at rest.
    most : int
        Reports a row.
    """
    n = len(target)
    row = np.full(n, -1)
    moving = np.zeros(n, dtype=np.int64)
    held = np.empty(most + 1, dtype=np.int64)
    size, rows = 0, 0
    for i in range(n):
        if size > 0 and target[held[0]] != target[i]:
            rows = _close(held, size, row, moving, rows, time, sensor, equations, dim, together)
            size = 0
        s = sensor[i]
        if size > 1 and _at_rest(held, size, time, together):
            apart = time[i] - time[held[0]]
            known = _count(held, size, sensor, s) > 0
            if apart > together and (known or apart > window):
                rows = _close(held, size, row, moving, rows, time, sensor, equations, dim, together)
                size = 0
        if size > 0 and time[i] - time[held[0]] > window:
            before = rows
            rows = _close(held, size, row, moving, rows, time, sensor, equations, dim, together)
            size = 0 if rows > before else _drop_old(held, size, time, time[i] - window)
        own = _count(held, size, sensor, s)
        if own > 0 and own == size:
            held[0], size = i, 1
            continue
        if own > 0 and time[_last(held, size, sensor, s)] == time[i]:
            continue  # a sensor says one thing of a target at a time
        bracket = own > 0 and sensor[held[0]] == s
        if own > 1 and not bracket:
            size = _drop_first(held, size, sensor, s)
        held[size] = i
        size += 1
        if (bracket and not _at_rest(held, size, time, together)) or size >= most:
            before = rows
            rows = _close(held, size, row, moving, rows, time, sensor, equations, dim, together)
            if rows > before:
                size = 0
            elif size >= most:
                held[: size - 1] = held[1:size].copy()
                size -= 1
    if size > 0:
        rows = _close(held, size, row, moving, rows, time, sensor, equations, dim, together)
    return row, moving[:rows]


@numba.njit(cache=True)
def _at_rest(held: IntArray, size: int, time: FloatArray, together: float) -> bool:
    return time[held[size - 1]] - time[held[0]] <= together


@numba.njit(cache=True)
def _count(held: IntArray, size: int, sensor: IntArray, s: int) -> int:
    found = 0
    for k in range(size):
        found += sensor[held[k]] == s
    return found


@numba.njit(cache=True)
def _last(held: IntArray, size: int, sensor: IntArray, s: int) -> int:
    for k in range(size - 1, -1, -1):
        if sensor[held[k]] == s:
            return held[k]
    return -1


@numba.njit(cache=True)
def _drop_old(held: IntArray, size: int, time: FloatArray, limit: float) -> int:
    kept = 0
    for k in range(size):
        if time[held[k]] >= limit:
            held[kept] = held[k]
            kept += 1
    return kept


@numba.njit(cache=True)
def _drop_first(held: IntArray, size: int, sensor: IntArray, s: int) -> int:
    """Without the first report of a sensor."""
    kept, dropped = 0, False
    for k in range(size):
        if not dropped and sensor[held[k]] == s:
            dropped = True
            continue
        held[kept] = held[k]
        kept += 1
    return kept


@numba.njit(cache=True)
def _close(
    held: IntArray,
    size: int,
    row: IntArray,
    moving: IntArray,
    rows: int,
    time: FloatArray,
    sensor: IntArray,
    equations: IntArray,
    dim: int,
    together: float,
) -> int:
    """Make a row of the reports held, if they say more than where the target is."""
    if _count(held, size, sensor, sensor[held[0]]) == size:
        return rows
    total, most = 0, 0
    for k in range(size):
        total += equations[sensor[held[k]]]
        most = max(most, equations[sensor[held[k]]])
    moves = 0 if _at_rest(held, size, time, together) else 1
    if total <= (1 + moves) * dim or most < dim:
        return rows  # bearings alone do not place a target well enough to linearise them
    for k in range(size):
        row[held[k]] = rows
    moving[rows] = moves
    return rows + 1
