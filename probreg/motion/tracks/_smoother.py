"""Compiled Bryson-Frazier smoother: no inverse of the process noise, equal times are harmless."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from probreg.motion.tracks._equations import Shape, TrackEquations, TrackMotion
from probreg.motion.tracks._filter import FAST, begin, gain_of, move, predict, project, shrink
from probreg.typing import FloatArray, IntArray


class Memory(NamedTuple):
    """What the filter leaves for the way back, of one target.

    Attributes
    ----------
    m : ndarray, shape (L, size)
    P : ndarray, shape (L, size, size)
        After the equations of each report: there the covariance is small, and V = P - P N P
        does not cancel.
    g : ndarray, shape (L', size)
    phi, nu : ndarray, shape (L',)
        Of each equation: gain times variance, predictive variance, innovation.
    """

    m: FloatArray
    P: FloatArray
    g: FloatArray
    phi: FloatArray
    nu: FloatArray


class Smoothing(NamedTuple):
    """Where the smoother writes; `which` and `spread` of length zero are left out.

    Attributes
    ----------
    mean : ndarray, shape (n, size)
    which : ndarray of int, shape (n,)
        In which place the covariance of each report goes; negative if it is not wanted.
    covariance : ndarray, shape (m, size, size)
    residual : ndarray, shape (E,)
        Of each equation against the smoothed state.
    spread : ndarray, shape (E, width)
        h V h' of each equation with those of its report.
    """

    mean: FloatArray
    which: IntArray
    covariance: FloatArray
    residual: FloatArray
    spread: FloatArray


@numba.njit(cache=True)
def memory_of(equations: TrackEquations) -> Memory:
    """Room for the largest target."""
    size = equations.push.shape[1] + equations.h.shape[1]
    longest, widest = 0, 0
    for k in range(len(equations.target_start) - 1):
        low, high = equations.target_start[k], equations.target_start[k + 1]
        longest = max(longest, high - low)
        widest = max(widest, equations.report_start[high] - equations.report_start[low])
    return Memory(
        np.empty((longest, size)),
        np.empty((longest, size, size)),
        np.empty((widest, size)),
        np.empty(widest),
        np.empty(widest),
    )


@numba.njit(cache=True, fastmath=FAST)
def forward(
    shape: Shape,
    equations: TrackEquations,
    motion: TrackMotion,
    precision: FloatArray,
    y: FloatArray,
    k: int,
    memory: Memory,
) -> None:
    """Filter target k and remember; phi is zero where an equation is not there."""
    size = 2 * len(shape[0]) + len(shape[1])
    m, P, none = np.empty(size), np.empty((size, size)), np.empty((size, 0))
    low, high = equations.target_start[k], equations.target_start[k + 1]
    base = equations.report_start[low]
    begin(shape, motion.start_mean[k], motion.start_variance[k], m, P)
    for i in range(low, high):
        dt = equations.time[i] - equations.time[i - 1] if i > low else 0.0
        if dt > 0.0:
            predict(shape, m, P, dt, motion.q[k])
            move(shape, m, none, dt, equations.push, i)
        for e in range(equations.report_start[i], equations.report_start[i + 1]):
            memory.phi[e - base] = 0.0
            if precision[e] == 0.0:
                continue
            g, h = memory.g[e - base], equations.h[e]
            phi = gain_of(shape, P, h, g) + 1.0 / precision[e]
            nu = y[e] - project(shape, h, m)
            memory.phi[e - base] = phi
            memory.nu[e - base] = nu
            shrink(shape, m, P, g, phi, nu)
        memory.m[i - low] = m
        memory.P[i - low] = P


@numba.njit(cache=True, fastmath=FAST, inline="always")
def give_back(
    shape: Shape,
    h: FloatArray,
    g: FloatArray,
    phi: float,
    nu: float,
    r: FloatArray,
    N: FloatArray,
    u: FloatArray,
) -> None:
    """Carry r and N back over one equation of gain k = g / phi; u is room to work in.

    r becomes r + h (nu / phi - k'r), N becomes (I - h k') N (I - k h') + h h' / phi.
    """
    d, c = len(shape[0]), len(shape[1])
    size = 2 * d + c
    lead, within = nu, phi
    for a in range(size):
        u[a] = 0.0
        for b in range(size):
            u[a] += N[b, a] * g[b]
        lead -= g[a] * r[a]
        within += g[a] * u[a]
    lead, within = lead / phi, within / (phi * phi)
    for b in range(d + c):
        row = b if b < d else b + d
        r[row] += h[b] * lead
        for a in range(size):
            N[row, a] -= h[b] * u[a] / phi
            N[a, row] -= h[b] * u[a] / phi
        for j in range(d + c):
            N[row, j if j < d else j + d] += h[b] * h[j] * within


@numba.njit(cache=True, fastmath=FAST, inline="always")
def carry_back(shape: Shape, r: FloatArray, N: FloatArray, dt: float) -> None:
    """Carry r and N back over dt seconds: F'r and F'N F."""
    d, size = len(shape[0]), 2 * len(shape[0]) + len(shape[1])
    for a in range(d):
        r[d + a] += dt * r[a]
    for a in range(d):
        for b in range(size):
            N[d + a, b] += dt * N[a, b]
    for a in range(size):
        for b in range(d):
            N[a, d + b] += dt * N[a, b]


@numba.njit(cache=True, fastmath=FAST, inline="always")
def smoothed_mean(
    shape: Shape, m: FloatArray, P: FloatArray, r: FloatArray, mean: FloatArray
) -> None:
    """Write m + P r."""
    size = 2 * len(shape[0]) + len(shape[1])
    for a in range(size):
        mean[a] = m[a]
        for b in range(size):
            mean[a] += P[a, b] * r[b]


@numba.njit(cache=True, fastmath=FAST)
def smoothed_covariance(
    shape: Shape, P: FloatArray, N: FloatArray, work: FloatArray, V: FloatArray
) -> None:
    """Write V = P - P N P."""
    size = 2 * len(shape[0]) + len(shape[1])
    for a in range(size):
        for b in range(size):
            work[a, b] = 0.0
        for c in range(size):
            for b in range(size):
                work[a, b] += P[a, c] * N[c, b]
    for a in range(size):
        for b in range(size):
            V[a, b] = P[a, b]
        for c in range(size):
            for b in range(size):
                V[a, b] -= work[a, c] * P[c, b]


@numba.njit(cache=True, fastmath=FAST)
def smooth_reports(
    shape: Shape,
    equations: TrackEquations,
    motion: TrackMotion,
    precision: FloatArray,
    y: FloatArray,
    out: Smoothing,
) -> None:
    """Smooth all targets; see `Smoothing`."""
    size = 2 * len(shape[0]) + len(shape[1])
    memory = memory_of(equations)
    m, P, gain, time, h = memory.m, memory.P, memory.g, equations.time, equations.h
    start, mean, which, covariance = equations.report_start, out.mean, out.which, out.covariance
    r, N, later, work = (
        np.empty(size),
        np.empty((size, size)),
        np.empty((size, size)),
        np.empty(size),
    )
    product, above = np.empty((size, size)), np.empty((max(1, out.spread.shape[1]), size))
    for k in range(len(motion.q)):
        forward(shape, equations, motion, precision, y, k, memory)
        low, high = equations.target_start[k], equations.target_start[k + 1]
        base = start[low]
        r[:] = 0.0
        N[:] = 0.0
        last = high - 1
        for i in range(high - 1, low - 1, -1):
            if i == high - 1 or time[i + 1] > time[i]:
                # the state of all reports at this time, best known after the last of them
                last = i
                later[:] = N
                smoothed_mean(shape, m[i - low], P[i - low], r, mean[i])
            else:
                mean[i] = mean[last]
            if len(which) > 0 and which[i] >= 0:
                smoothed_covariance(shape, P[last - low], later, product, covariance[which[i]])
            for e in range(start[i], start[i + 1]):
                out.residual[e] = y[e] - project(shape, h[e], mean[i])
            if len(out.spread) > 0:
                own = out.spread[start[i] : start[i + 1]]
                spread_of(shape, h[start[i] : start[i + 1]], P[last - low], later, own, above, work)
            for e in range(start[i + 1] - 1, start[i] - 1, -1):
                phi = memory.phi[e - base]
                if phi > 0.0:
                    give_back(shape, h[e], gain[e - base], phi, memory.nu[e - base], r, N, work)
            if i > low:
                carry_back(shape, r, N, time[i] - time[i - 1])


@numba.njit(cache=True, fastmath=FAST, inline="always")
def spread_of(
    shape: Shape,
    h: FloatArray,
    P: FloatArray,
    N: FloatArray,
    spread: FloatArray,
    above: FloatArray,
    work: FloatArray,
) -> None:
    """Write h V h' of the equations of a report, V = P - P N P."""
    size = 2 * len(shape[0]) + len(shape[1])
    for e in range(len(h)):
        gain_of(shape, P, h[e], above[e])
        for a in range(size):
            work[a] = 0.0
        for b in range(size):
            for a in range(size):
                work[a] += N[b, a] * above[e, b]
        for f in range(e + 1):
            within = project(shape, h[e], above[f])
            for a in range(size):
                within -= work[a] * above[f, a]
            spread[e, f] = spread[f, e] = within
