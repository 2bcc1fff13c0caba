"""Compiled Kalman filter that carries the bias columns along (de Jong 1991).

State: position (d), velocity (d), constants of the target (c). All functions work in place on
small arrays made once a call. Their sizes are known when they are compiled (`Shape`), so that
short loops are unrolled.
"""

from __future__ import annotations

import numba
import numpy as np

from probreg.motion.tracks._equations import Shape, TrackEquations, TrackMotion
from probreg.typing import FloatArray

_LOG_2PI = float(np.log(2.0 * np.pi))
# contraction and reassociation only: NaN and infinity keep their meaning
FAST = {"contract", "reassoc", "nsz", "arcp"}


@numba.njit(cache=True, fastmath=FAST)
def begin(
    shape: Shape, mean: FloatArray, variance: FloatArray, m: FloatArray, P: FloatArray
) -> None:
    """Write the start of a target into m and P: variances (size,) or a covariance."""
    size = 2 * len(shape[0]) + len(shape[1])
    for a in range(size):
        m[a] = mean[a]
        for b in range(size):
            # of the two only one is compiled
            if variance.ndim == 2:
                P[a, b] = variance[a, b]
            else:
                P[a, b] = variance[a] if a == b else 0.0


@numba.njit(cache=True, fastmath=FAST, inline="always")
def predict(shape: Shape, m: FloatArray, P: FloatArray, dt: float, q: float) -> None:
    """Move mean and covariance on by dt: F = [I, dt I; 0, I], white acceleration of density q."""
    d, size = len(shape[0]), 2 * len(shape[0]) + len(shape[1])
    for a in range(d):
        m[a] += dt * m[d + a]
    # rows of positions, then columns: P <- F P F'
    for a in range(d):
        for b in range(size):
            P[a, b] += dt * P[d + a, b]
    for a in range(size):
        for b in range(d):
            P[a, b] += dt * P[a, d + b]
    half, third = 0.5 * q * dt * dt, q * dt * dt * dt / 3.0
    for a in range(d):
        P[a, a] += third
        P[a, d + a] += half
        P[d + a, a] += half
        P[d + a, d + a] += q * dt


@numba.njit(cache=True, fastmath=FAST, inline="always")
def gain_of(shape: Shape, P: FloatArray, h: FloatArray, g: FloatArray) -> float:
    """Write g = P h; returns h . g. h counts positions and constants, not velocities."""
    d, c = len(shape[0]), len(shape[1])
    for a in range(2 * d + c):
        g[a] = 0.0
    for b in range(d + c):
        # a row of the symmetric P, so that memory is read in order
        row = b if b < d else b + d
        for a in range(2 * d + c):
            g[a] += P[row, a] * h[b]
    spread = 0.0
    for b in range(d + c):
        spread += h[b] * g[b if b < d else b + d]
    return spread


@numba.njit(cache=True, fastmath=FAST, inline="always")
def project(shape: Shape, h: FloatArray, x: FloatArray) -> float:
    """Part h . (position, constants) of a state."""
    d, value = len(shape[0]), 0.0
    for b in range(d + len(shape[1])):
        value += h[b] * x[b if b < d else b + d]
    return value


@numba.njit(cache=True, fastmath=FAST, inline="always")
def shrink(
    shape: Shape, m: FloatArray, P: FloatArray, g: FloatArray, phi: float, nu: float
) -> None:
    """Take one equation in: m += g nu / phi, P -= g g' / phi."""
    size = 2 * len(shape[0]) + len(shape[1])
    for a in range(size):
        scaled = g[a] / phi
        m[a] += scaled * nu
        for b in range(size):
            P[a, b] -= scaled * g[b]


@numba.njit(cache=True, fastmath=FAST, inline="always")
def answer(shape: Shape, equations: TrackEquations, e: int, M: FloatArray, n: FloatArray) -> None:
    """Write n = s - M'h: what the innovation of equation e loses for each unit of bias."""
    d, p = len(shape[0]), n.size
    for c in range(p):
        n[c] = 0.0
    for s in range(equations.column.shape[1]):
        n[equations.column[e, s]] += equations.response[e, s]
    for b in range(d + len(shape[1])):
        h, row = equations.h[e, b], b if b < d else b + d
        for c in range(p):
            n[c] -= h * M[row, c]


@numba.njit(cache=True, fastmath=FAST, inline="always")
def move(shape: Shape, m: FloatArray, M: FloatArray, dt: float, push: FloatArray, i: int) -> None:
    """Move the bias columns on by dt, and the mean by the known acceleration."""
    d = len(shape[0])
    for a in range(d):
        for c in range(M.shape[1]):
            M[a, c] += dt * M[d + a, c]
        if len(push) > 0:
            m[a] += 0.5 * dt * dt * push[i, a]
            m[d + a] += dt * push[i, a]


@numba.njit(cache=True, fastmath=FAST)
def information(
    shape: Shape,
    equations: TrackEquations,
    motion: TrackMotion,
    precision: FloatArray,
    J: FloatArray,
    eta: FloatArray,
    ll: FloatArray,
) -> None:
    """Gaussian information of each target about the biases, its path eliminated.

    Writes J (K, p, p), eta (K, p), ll (K,): log p(y | delta) is ll + eta.delta - delta'J delta / 2.
    """
    p, size = eta.shape[1], 2 * len(shape[0]) + len(shape[1])
    m, P, M = np.empty(size), np.empty((size, size)), np.empty((size, p))
    g, n = np.empty(size), np.empty(p)
    for k in range(len(ll)):
        begin(shape, motion.start_mean[k], motion.start_variance[k], m, P)
        M[:] = 0.0
        Jk, etak, log_density = J[k], eta[k], 0.0
        Jk[:] = 0.0
        etak[:] = 0.0
        low, high = equations.target_start[k], equations.target_start[k + 1]
        for i in range(low, high):
            dt = equations.time[i] - equations.time[i - 1] if i > low else 0.0
            if dt > 0.0:
                predict(shape, m, P, dt, motion.q[k])
                move(shape, m, M, dt, equations.push, i)
            for e in range(equations.report_start[i], equations.report_start[i + 1]):
                if precision[e] == 0.0:
                    continue
                h = equations.h[e]
                phi = gain_of(shape, P, h, g) + 1.0 / precision[e]
                nu = equations.y[e] - project(shape, h, m)
                answer(shape, equations, e, M, n)
                log_density -= 0.5 * (_LOG_2PI + np.log(phi) + nu * nu / phi)
                for a in range(p):
                    part = n[a] / phi
                    etak[a] += part * nu
                    for c in range(a + 1):
                        Jk[a, c] += part * n[c]
                for a in range(size):
                    part = g[a] / phi
                    for c in range(p):
                        M[a, c] += part * n[c]
                shrink(shape, m, P, g, phi, nu)
        ll[k] = log_density
        for a in range(p):
            for c in range(a):
                Jk[c, a] = Jk[a, c]
