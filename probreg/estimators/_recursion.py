"""The one recursion behind every recursive estimator, compiled.

In whitened coordinates the measurement noise of a row is diag(1 / w), so its components
enter one after the other as scalars: the same update as with the m x m gain, without a
matrix inversion. P is carried as a square root S (P = S S'), by Potter's update, so it
stays positive definite whatever the units.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from probreg.noise import LawNumbers
from probreg.typing import FloatArray, IntArray


class Rows(NamedTuple):
    """Whitened rows in the order in which they are taken.

    Attributes
    ----------
    v : ndarray, shape (n, M)
    A : ndarray, shape (n, M, p)
    size : ndarray of int, shape (n,)
        Real components of each row.
    """

    v: FloatArray
    A: FloatArray
    size: IntArray


class Drift(NamedTuple):
    """How the unknowns move before each row.

    Attributes
    ----------
    at : ndarray of int, shape (n,)
        Which step comes before a row; -1 for none.
    F, roots : ndarray, shape (k, p, p)
        The different steps, and square roots of their noise.
    grow : float
        Factor on the square root of P at each step.
    """

    at: IntArray
    F: FloatArray
    roots: FloatArray
    grow: float


class State(NamedTuple):
    """The estimate (p,) and a square root (p, p) of its covariance; changed in place."""

    theta: FloatArray
    S: FloatArray


class Written(NamedTuple):
    """What each row leaves: the recursion fills these arrays.

    Attributes
    ----------
    weights : ndarray, shape (n, M)
    path : ndarray, shape (n, p)
        The estimate after each row.
    covariances : ndarray, shape (n, p, p) or (0, p, p)
        P after each row, where there is room for it.
    """

    weights: FloatArray
    path: FloatArray
    covariances: FloatArray


@numba.njit(cache=True)
def recurse(
    rows: Rows,
    weight: Any,
    law: LawNumbers,
    componentwise: bool,
    drift: Drift,
    state: State,
    written: Written,
) -> None:
    """Run through whitened rows, changing the state and filling what is written."""
    v, A = rows.v, rows.A
    theta, S, weights = state.theta, state.S, written.weights
    params = law.params
    n, _, p = A.shape
    inverse_unit2 = 1.0 / (law.unit * law.unit)
    f = np.empty(p, dtype=v.dtype)
    g = np.empty(p, dtype=v.dtype)
    for i in range(n):
        if drift.at[i] >= 0:
            _move(drift.F[drift.at[i]], drift.roots[drift.at[i]], drift.grow, theta, S)
        size = rows.size[i]
        d2 = 0.0
        for c in range(size):
            e = v[i, c]
            for k in range(p):
                e -= A[i, c, k] * theta[k]
            if componentwise:
                weights[i, c] = weight(e * e * inverse_unit2, 1.0, params) * inverse_unit2
            d2 += e * e
        if not componentwise:
            w = weight(d2 * inverse_unit2, float(size), params) * inverse_unit2
            for c in range(size):
                weights[i, c] = w
        for c in range(size):
            if weights[i, c] > 0.0:
                _scalar_update(v[i, c], A[i, c], 1.0 / weights[i, c], theta, S, f, g)
        written.path[i] = theta
        if written.covariances.shape[0] > 0:
            written.covariances[i] = S @ S.T


@numba.njit(cache=True)
def _move(F: FloatArray, root: FloatArray, grow: float, theta: FloatArray, S: FloatArray) -> None:
    """One step; P is never formed: S S' = F S S' F' grow^2 + root root' by triangularisation."""
    p = theta.size
    theta[:] = F @ theta
    stacked = np.empty((2 * p, p), dtype=S.dtype)
    stacked[:p] = grow * (F @ S).T
    stacked[p:] = root.T
    S[:] = np.linalg.qr(stacked)[1].T


@numba.njit(cache=True)
def _scalar_update(
    z: float,
    a: FloatArray,
    variance: float,
    theta: FloatArray,
    S: FloatArray,
    f: FloatArray,
    g: FloatArray,
) -> None:
    p = theta.size
    e = z
    total = variance
    for k in range(p):
        e -= a[k] * theta[k]
        s = 0.0
        for j in range(p):
            s += S[j, k] * a[j]
        f[k] = s
        total += s * s
    shrink = 1.0 / (total + np.sqrt(total * variance))
    for k in range(p):
        s = 0.0
        for j in range(p):
            s += S[k, j] * f[j]
        g[k] = s
    for k in range(p):
        theta[k] += g[k] * (e / total)
        for j in range(p):
            S[k, j] -= shrink * g[k] * f[j]
