"""Compiled filter that carries the columns of drifting biases as long as a track knows of them."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from probreg.motion.tracks._equations import Shape, TrackEquations, TrackMotion
from probreg.motion.tracks._filter import FAST, begin, gain_of, predict, project, shrink
from probreg.typing import FloatArray, IntArray

_LOG_2PI = float(np.log(2.0 * np.pi))


class Window(NamedTuple):
    """Columns: constant ones first, then of all drifting biases knot by knot; how many knots live.

    Attributes
    ----------
    static, drifting : int
    knots, live : int
        In all; carried along.
    """

    static: int
    drifting: int
    knots: int
    live: int


class Totals(NamedTuple):
    """Where the filter writes: J (P, P) over all targets, eta (K, P) and ll (K,) by target."""

    J: FloatArray
    eta: FloatArray
    ll: FloatArray


class Local(NamedTuple):
    """The live columns of one target: places of their blocks of knots turn round in a ring.

    Attributes
    ----------
    M : ndarray, shape (size, L)
    J : ndarray, shape (L, L)
        Lower triangle.
    eta, n : ndarray, shape (L,)
    place : ndarray of int, shape (L,)
        Where each stands among all columns.
    """

    M: FloatArray
    J: FloatArray
    eta: FloatArray
    n: FloatArray
    place: IntArray


@numba.njit(cache=True, fastmath=FAST)
def drifting_information(
    shape: Shape,
    equations: TrackEquations,
    motion: TrackMotion,
    precision: FloatArray,
    window: Window,
    totals: Totals,
) -> None:
    """Gaussian information about all coefficients, every path eliminated; see `information`."""
    size, L = 2 * len(shape[0]) + len(shape[1]), window.static + window.live * window.drifting
    m, P, g = np.empty(size), np.empty((size, size)), np.empty(size)
    local = Local(
        np.zeros((size, L)), np.zeros((L, L)), np.zeros(L), np.zeros(L), np.zeros(L, np.int64)
    )
    for c in range(window.static):
        local.place[c] = c
    totals.J[:] = 0.0
    totals.eta[:] = 0.0
    for k in range(len(totals.ll)):
        begin(shape, motion.start_mean[k], motion.start_variance[k], m, P)
        local.M[:] = 0.0
        oldest, log_density = -1, 0.0
        low, high = equations.target_start[k], equations.target_start[k + 1]
        for i in range(low, high):
            dt = equations.time[i] - equations.time[i - 1] if i > low else 0.0
            if dt > 0.0:
                predict(shape, m, P, dt, motion.q[k])
                _move(shape, m, local.M, dt, equations.push, i)
            for e in range(equations.report_start[i], equations.report_start[i + 1]):
                if precision[e] == 0.0:
                    continue
                oldest = _bring(equations, e, window, oldest, local, totals, k)
                h = equations.h[e]
                phi = gain_of(shape, P, h, g) + 1.0 / precision[e]
                nu = equations.y[e] - project(shape, h, m)
                _answer(shape, equations, e, window, oldest, local)
                log_density -= 0.5 * (_LOG_2PI + np.log(phi) + nu * nu / phi)
                _count(local, g, phi, nu)
                shrink(shape, m, P, g, phi, nu)
        totals.ll[k] = log_density
        _hand_over(local, 0, L, totals, k)
    for a in range(len(totals.J)):
        for c in range(a):
            totals.J[a, c] = totals.J[c, a] = totals.J[a, c] + totals.J[c, a]


@numba.njit(cache=True, fastmath=FAST, inline="always")
def _move(shape: Shape, m: FloatArray, M: FloatArray, dt: float, push: FloatArray, i: int) -> None:
    """As `move`, of arrays that stand in a tuple."""
    d = len(shape[0])
    for a in range(d):
        for c in range(M.shape[1]):
            M[a, c] += dt * M[d + a, c]
        if len(push) > 0:
            m[a] += 0.5 * dt * dt * push[i, a]
            m[d + a] += dt * push[i, a]


@numba.njit(cache=True, fastmath=FAST)
def _bring(
    equations: TrackEquations,
    e: int,
    window: Window,
    oldest: int,
    local: Local,
    totals: Totals,
    k: int,
) -> int:
    """Move the window on until it has the knots of equation e; returns its oldest knot.

    What the path answers to the knot that leaves, it then answers to the next one.
    """
    first, last = window.knots, -1
    for s in range(equations.column.shape[1]):
        c = equations.column[e, s]
        if c >= window.static and equations.response[e, s] != 0.0:
            knot = (c - window.static) // window.drifting
            first, last = min(first, knot), max(last, knot)
    if last < 0:
        return oldest
    d = window.drifting
    if oldest < 0:
        oldest = min(first, window.knots - window.live)
        for knot in range(oldest, oldest + window.live):
            at = window.static + (knot % window.live) * d
            for j in range(d):
                local.place[at + j] = window.static + knot * d + j
    while last >= oldest + window.live:
        at = window.static + (oldest % window.live) * d
        after = window.static + ((oldest + 1) % window.live) * d
        _hand_over(local, at, at + d, totals, k)
        for j in range(d):
            for a in range(len(local.M)):
                local.M[a, after + j] += local.M[a, at + j]
                local.M[a, at + j] = 0.0
            local.place[at + j] += window.live * d
        oldest += 1
    return oldest


@numba.njit(cache=True, fastmath=FAST)
def _hand_over(local: Local, low: int, high: int, totals: Totals, k: int) -> None:
    """Add what is known of live columns from low to high to the totals, and forget it here."""
    L, place = len(local.eta), local.place
    for a in range(low, high):
        totals.eta[k, place[a]] += local.eta[a]
        local.eta[a] = 0.0
        for c in range(L):
            row, column = (a, c) if c <= a else (c, a)
            value = local.J[row, column]
            if value != 0.0:
                if row == column:
                    totals.J[place[a], place[a]] += value
                else:
                    totals.J[place[row], place[column]] += value
                local.J[row, column] = 0.0


@numba.njit(cache=True, fastmath=FAST, inline="always")
def _answer(
    shape: Shape, equations: TrackEquations, e: int, window: Window, oldest: int, local: Local
) -> None:
    """Write n = s - M'h of the live columns; a knot that has left counts as the oldest."""
    d, L, n = len(shape[0]), len(local.eta), local.n
    for c in range(L):
        n[c] = 0.0
    for s in range(equations.column.shape[1]):
        c, response = equations.column[e, s], equations.response[e, s]
        if response == 0.0:
            continue
        if c >= window.static:
            knot = (c - window.static) // window.drifting
            j = (c - window.static) % window.drifting
            c = window.static + (max(knot, oldest) % window.live) * window.drifting + j
        n[c] += response
    for b in range(d + len(shape[1])):
        h, row = equations.h[e, b], b if b < d else b + d
        for c in range(L):
            n[c] -= h * local.M[row, c]


@numba.njit(cache=True, fastmath=FAST, inline="always")
def _count(local: Local, g: FloatArray, phi: float, nu: float) -> None:
    """Take one equation in: information, and what the path answers to the columns."""
    L, n, eta, J, M = len(local.eta), local.n, local.eta, local.J, local.M
    for a in range(L):
        part = n[a] / phi
        eta[a] += part * nu
        for c in range(a + 1):
            J[a, c] += part * n[c]
    for a in range(len(g)):
        part = g[a] / phi
        for c in range(L):
            M[a, c] += part * n[c]
