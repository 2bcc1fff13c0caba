"""Compiled filter that goes on from where it stopped, with a column for every knot of a bias."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from probreg.motion.tracks._equations import Shape, TrackEquations, TrackMotion
from probreg.motion.tracks._filter import FAST, begin, gain_of, move, predict, project, shrink
from probreg.typing import FloatArray, IntArray

_LOG_2PI = float(np.log(2.0 * np.pi))


class Sums(NamedTuple):
    """Information about the columns from each group of reports, given those before.

    Attributes
    ----------
    J : ndarray, shape (groups, C, C)
    eta : ndarray, shape (groups, C)
    log_likelihood : ndarray, shape (groups,)
    """

    J: FloatArray
    eta: FloatArray
    log_likelihood: FloatArray


class LiveTracks(NamedTuple):
    """Targets' states, and what their means lose for each unit of bias.

    Attributes
    ----------
    mean : ndarray, shape (K, size)
    covariance : ndarray, shape (K, size, size)
    columns : ndarray, shape (K, size, C)
    time : ndarray, shape (K,)
    """

    mean: FloatArray
    covariance: FloatArray
    columns: FloatArray
    time: FloatArray


@numba.njit(cache=True, fastmath=FAST, inline="always")
def answer_knots(
    shape: Shape, equations: TrackEquations, e: int, M: FloatArray, n: FloatArray, top: int
) -> None:
    """Write n = s - M'h of equation e, up to column `top`: later knots have no part in it yet."""
    d = len(shape[0])
    for c in range(top):
        n[c] = 0.0
    for s in range(equations.column.shape[1]):
        n[equations.column[e, s]] += equations.response[e, s]
    for b in range(d + len(shape[1])):
        h, row = equations.h[e, b], M[b if b < d else b + d]
        for c in range(top):
            n[c] -= h * row[c]


@numba.njit(cache=True, fastmath=FAST)
def follow(
    shape: Shape,
    equations: TrackEquations,
    motion: TrackMotion,
    precision: FloatArray,
    places: tuple[IntArray, IntArray],
    live: LiveTracks,
    sums: Sums,
) -> None:
    """Filter all targets from their starts; `live` holds their columns, and is written to.

    `places` are the end (n,) of each report's columns and its group (n,), both going up in time.
    `live` becomes the state after each target's last report of group 0, if it has one.
    """
    C, size = sums.eta.shape[1], 2 * len(shape[0]) + len(shape[1])
    m, P, M = np.empty(size), np.empty((size, size)), np.empty((size, C))
    g, n, (ends, group) = np.empty(size), np.empty(C), places
    for k in range(len(motion.q)):
        begin(shape, motion.start_mean[k], motion.start_variance[k], m, P)
        M[:] = live.columns[k]
        low, high = equations.target_start[k], equations.target_start[k + 1]
        for i in range(low, high):
            dt = equations.time[i] - equations.time[i - 1] if i > low else 0.0
            if dt > 0.0:
                predict(shape, m, P, dt, motion.q[k])
                move(shape, m, M, dt, equations.push, i)
            J, eta, top = sums.J[group[i]], sums.eta[group[i]], ends[i]
            for e in range(equations.report_start[i], equations.report_start[i + 1]):
                if precision[e] == 0.0:
                    continue
                h = equations.h[e]
                phi = gain_of(shape, P, h, g) + 1.0 / precision[e]
                nu = equations.y[e] - project(shape, h, m)
                answer_knots(shape, equations, e, M, n, top)
                sums.log_likelihood[group[i]] -= 0.5 * (_LOG_2PI + np.log(phi) + nu * nu / phi)
                for a in range(top):
                    part = n[a] / phi
                    eta[a] += part * nu
                    for c in range(a + 1):
                        J[a, c] += part * n[c]
                for a in range(size):
                    part = g[a] / phi
                    for c in range(top):
                        M[a, c] += part * n[c]
                shrink(shape, m, P, g, phi, nu)
            if group[i] == 0:
                live.mean[k] = m
                live.covariance[k] = P
                live.columns[k] = M
                live.time[k] = equations.time[i]
