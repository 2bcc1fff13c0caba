"""Compiled: a straight path fitted to the reports of each row, and taken out of them.

A report of a row at time dt gives `count` equations e = G x(dt) + S theta + noise, noise
covariance C; x is a straight line (a point, where the row is at rest) plus the path of white
acceleration. Rows may differ in everything, so they are worked through one by one.
"""

from __future__ import annotations

import numba
import numpy as np

from probreg.typing import FloatArray, IntArray

_SPEED_M_S = 3_000.0  # no target is faster; keeps velocities sane where a row hardly tells them


@numba.njit(cache=True, error_model="numpy")
def fit_paths(
    start: IntArray,
    moving: IntArray,
    dt: FloatArray,
    count: IntArray,
    e: FloatArray,
    G: FloatArray,
    C: FloatArray,
    psd: float,
) -> tuple[FloatArray, FloatArray]:
    """Generalised least squares of each row: position (n, d) and velocity (n, d) by report."""
    n, d = e.shape
    where, speed = np.zeros((n, d)), np.zeros((n, d))
    for r in range(len(moving)):
        a, b = start[r], start[r + 1]
        m, width = _equations(count, a, b), d * (1 + moving[r])
        R, span = _covariance(dt, count, G, C, psd, a, b, m), _span(dt, a, b)
        left = np.zeros((m, width + 1))
        _design(dt, count, G, e, a, b, moving[r], span, left)
        _whiten(R, left)
        normal = np.zeros((width, width + 1))
        for i in range(width):
            for j in range(width + 1):
                for k in range(m):
                    normal[i, j] += left[k, i] * left[k, j]
        for i in range(d, width):
            normal[i, i] += 1.0 / (_SPEED_M_S * span) ** 2
        line = _solve(normal)
        for i in range(a, b):
            for c in range(d):
                where[i, c] = line[c]
                if moving[r]:
                    where[i, c] += line[d + c] * dt[i] / span
                    speed[i, c] = line[d + c] / span
    return where, speed


@numba.njit(cache=True, error_model="numpy")
def eliminate(
    start: IntArray,
    moving: IntArray,
    dt: FloatArray,
    count: IntArray,
    e: FloatArray,
    G: FloatArray,
    C: FloatArray,
    S: FloatArray,
    columns: IntArray,
    psd: float,
    y: FloatArray,
    B: FloatArray,
    R: FloatArray,
) -> None:
    """Project every row on what no straight path explains; fills y, B, R of zeros and units.

    S (n, d, k) belongs to the unknowns columns (n, k), -1 for none. The basis is orthonormal,
    by Householder reflections.
    """
    d, p = e.shape[1], B.shape[2]
    for r in range(len(moving)):
        a, b = start[r], start[r + 1]
        m, width = _equations(count, a, b), d * (1 + moving[r])
        noise = _covariance(dt, count, G, C, psd, a, b, m)
        left = np.zeros((m, width + 1 + p))
        _design(dt, count, G, e, a, b, moving[r], _span(dt, a, b), left)
        k = 0
        for i in range(a, b):
            for q in range(count[i]):
                for j in range(columns.shape[1]):
                    if columns[i, j] >= 0:
                        left[k, width + 1 + columns[i, j]] += S[i, q, j]
                k += 1
        _reflect(left, noise, width)
        for i in range(m - width):
            y[r, i] = left[width + i, width]
            for j in range(p):
                B[r, i, j] = left[width + i, width + 1 + j]
            for j in range(m - width):
                R[r, i, j] = noise[width + i, width + j]


@numba.njit(cache=True, error_model="numpy")
def _equations(count: IntArray, a: int, b: int) -> int:
    total = 0
    for i in range(a, b):
        total += count[i]
    return total


@numba.njit(cache=True, error_model="numpy")
def _span(dt: FloatArray, a: int, b: int) -> float:
    longest = 0.0
    for i in range(a, b):
        longest = max(longest, abs(dt[i]))
    return max(longest, 1e-9)


@numba.njit(cache=True, error_model="numpy")
def _covariance(
    dt: FloatArray,
    count: IntArray,
    G: FloatArray,
    C: FloatArray,
    psd: float,
    a: int,
    b: int,
    m: int,
) -> FloatArray:
    """Noise of the reports and of the path: the twice integrated Wiener process."""
    R, d = np.zeros((m, m)), G.shape[2]
    earliest = dt[a]
    for i in range(a, b):
        earliest = min(earliest, dt[i])
    row = 0
    for i in range(a, b):
        column = 0
        for j in range(a, i + 1):
            s, t = dt[i] - earliest, dt[j] - earliest
            s, t = min(s, t), max(s, t)
            path = psd * s * s * (0.5 * t - s / 6.0)
            for q in range(count[i]):
                for o in range(count[j]):
                    value = C[i, q, o] if i == j else 0.0
                    for c in range(d):
                        value += path * G[i, q, c] * G[j, o, c]
                    R[row + q, column + o] = value
                    R[column + o, row + q] = value
            column += count[j]
        row += count[i]
    return R


@numba.njit(cache=True, error_model="numpy")
def _design(
    dt: FloatArray,
    count: IntArray,
    G: FloatArray,
    e: FloatArray,
    a: int,
    b: int,
    moves: int,
    span: float,
    left: FloatArray,
) -> None:
    """Columns for position, for velocity times the span, and the left-hand side."""
    d, k = e.shape[1], 0
    for i in range(a, b):
        for q in range(count[i]):
            for c in range(d):
                left[k, c] = G[i, q, c]
                if moves:
                    left[k, d + c] = G[i, q, c] * dt[i] / span
            left[k, d * (1 + moves)] = e[i, q]
            k += 1


@numba.njit(cache=True, error_model="numpy")
def _whiten(R: FloatArray, left: FloatArray) -> None:
    """Multiply by the inverse Cholesky factor of R, in place."""
    m, width = left.shape
    for i in range(m):
        for j in range(i + 1):
            s = R[i, j]
            for k in range(j):
                s -= R[i, k] * R[j, k]
            R[i, j] = np.sqrt(s) if i == j else s / R[j, j]
        for c in range(width):
            s = left[i, c]
            for k in range(i):
                s -= R[i, k] * left[k, c]
            left[i, c] = s / R[i, i]


@numba.njit(cache=True, error_model="numpy")
def _solve(normal: FloatArray) -> FloatArray:
    """Solve a symmetric positive definite system whose right-hand side is the last column."""
    n = len(normal)
    right = normal[:, n:].copy()
    _whiten(normal, right)
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i, 0] -= normal[k, i] * right[k, 0]
        right[i, 0] /= normal[i, i]
    return right[:, 0]


@numba.njit(cache=True, error_model="numpy")
def _reflect(left: FloatArray, R: FloatArray, width: int) -> None:
    """Triangularise the first columns; the same reflections on the rest and on both sides of R."""
    m, across = left.shape
    v = np.zeros(m)
    for c in range(width):
        length = 0.0
        for k in range(c, m):
            length += left[k, c] * left[k, c]
        length = np.sqrt(length)
        if length == 0.0:
            continue
        v[:c] = 0.0
        v[c:] = left[c:, c]
        v[c] += length if v[c] >= 0.0 else -length
        square = 0.0
        for k in range(c, m):
            square += v[k] * v[k]
        for j in range(c, across):
            s = 0.0
            for k in range(c, m):
                s += v[k] * left[k, j]
            s *= 2.0 / square
            for k in range(c, m):
                left[k, j] -= s * v[k]
        for j in range(m):
            s = 0.0
            for k in range(c, m):
                s += v[k] * R[k, j]
            s *= 2.0 / square
            for k in range(c, m):
                R[k, j] -= s * v[k]
        for i in range(m):
            s = 0.0
            for k in range(c, m):
                s += R[i, k] * v[k]
            s *= 2.0 / square
            for k in range(c, m):
                R[i, k] -= s * v[k]
