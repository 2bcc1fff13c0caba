"""Linear algebra of symmetric matrices: compiled on stacks of small ones, equilibrated on one."""

from __future__ import annotations

import numba
import numpy as np
from scipy import linalg

from probreg.typing import FloatArray

_SWEEPS = 30  # Jacobi converges quadratically; 3 x 3 needs about four


@numba.njit(cache=True, error_model="numpy")
def inverse_roots(matrices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Symmetric inverse square roots (n, m, m) and log-determinants (n,), by cyclic Jacobi.

    The matrices must be symmetric positive definite.
    """
    n, m, _ = matrices.shape
    roots, log_det = np.empty_like(matrices), np.zeros(n)
    for i in range(n):
        D, V = matrices[i].copy(), np.eye(m)
        _diagonalise(D, V)
        for k in range(m):
            log_det[i] += np.log(D[k, k])
            D[k, k] = 1.0 / np.sqrt(D[k, k])
        for a in range(m):
            for b in range(a + 1):
                s = 0.0
                for k in range(m):
                    s += V[a, k] * V[b, k] * D[k, k]
                roots[i, a, b] = s
                roots[i, b, a] = s
    return roots, log_det


@numba.njit(cache=True, error_model="numpy")
def _diagonalise(D: FloatArray, V: FloatArray) -> None:
    """Rotate D to diagonal form in place, gathering the rotations in V."""
    m = D.shape[0]
    for _ in range(_SWEEPS):
        clean = True
        for p in range(m - 1):
            for q in range(p + 1, m):
                if D[p, q] * D[p, q] <= 1e-32 * abs(D[p, p] * D[q, q]):
                    continue
                clean = False
                ratio = (D[q, q] - D[p, p]) / (2.0 * D[p, q])
                t = 1.0 / (abs(ratio) + np.sqrt(1.0 + ratio * ratio))
                t = t if ratio >= 0.0 else -t
                c = 1.0 / np.sqrt(1.0 + t * t)
                s = t * c
                for k in range(m):
                    D[k, p], D[k, q] = c * D[k, p] - s * D[k, q], s * D[k, p] + c * D[k, q]
                for k in range(m):
                    D[p, k], D[q, k] = c * D[p, k] - s * D[q, k], s * D[p, k] + c * D[q, k]
                    V[k, p], V[k, q] = c * V[k, p] - s * V[k, q], s * V[k, p] + c * V[k, q]
        if clean:
            return


@numba.njit(cache=True, error_model="numpy")
def weighted_gram(J: FloatArray, variances: FloatArray) -> FloatArray:
    """Products J diag(variances) J' of a stack (n, d, q), shape (n, d, d)."""
    n, d, q = J.shape
    out = np.empty((n, d, d))
    for i in range(n):
        for a in range(d):
            for b in range(a + 1):
                s = 0.0
                for k in range(q):
                    s += J[i, a, k] * variances[k] * J[i, b, k]
                out[i, a, b] = s
                out[i, b, a] = s
    return out


@numba.njit(cache=True, error_model="numpy")
def precision_weighted_mean(covariances: FloatArray, positions: FloatArray) -> FloatArray:
    """Fuse k positions (k, n, d) with covariances (k, n, d, d) row by row, shape (n, d)."""
    k, n, d = positions.shape
    fused = np.empty((n, d))
    root, column, total, moment = np.empty((d, d)), np.empty(d), np.empty((d, d)), np.empty(d)
    for i in range(n):
        total[:] = 0.0
        moment[:] = 0.0
        for s in range(k):
            _cholesky(covariances[s, i], root)
            for a in range(d):
                column[:] = 0.0
                column[a] = 1.0
                _solve(root, column)
                for b in range(d):
                    total[b, a] += column[b]
                    moment[b] += column[b] * positions[s, i, a]
        _cholesky(total, root)
        _solve(root, moment)
        fused[i] = moment
    return fused


@numba.njit(cache=True, error_model="numpy")
def _cholesky(matrix: FloatArray, root: FloatArray) -> None:
    """Lower triangular factor, its diagonal inverted: divisions are what costs here."""
    for a in range(matrix.shape[0]):
        for b in range(a + 1):
            s = matrix[a, b]
            for k in range(b):
                s -= root[a, k] * root[b, k]
            root[a, b] = 1.0 / np.sqrt(s) if a == b else s * root[b, b]


@numba.njit(cache=True, error_model="numpy")
def _solve(root: FloatArray, x: FloatArray) -> None:
    """Solve L L' x = b in place."""
    d = x.size
    for a in range(d):
        for k in range(a):
            x[a] -= root[a, k] * x[k]
        x[a] *= root[a, a]
    for a in range(d - 1, -1, -1):
        for k in range(a + 1, d):
            x[a] -= root[k, a] * x[k]
        x[a] *= root[a, a]


def spd_solve(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solve with a symmetric positive definite matrix of very different diagonal entries.

    Raises
    ------
    scipy.linalg.LinAlgError
        Not positive definite.
    """
    root, scale = _equilibrated(matrix)
    return linalg.cho_solve((root, True), right / scale) / scale


def spd_inverse(matrix: FloatArray) -> FloatArray:
    """Inverse of a symmetric positive definite matrix of very different diagonal entries.

    Raises
    ------
    scipy.linalg.LinAlgError
        Not positive definite.
    """
    root, scale = _equilibrated(matrix)
    inverse = linalg.cho_solve((root, True), np.eye(len(matrix)))
    return inverse / np.outer(scale, scale)


def _equilibrated(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lower root of the matrix scaled to a unit diagonal, and the scales."""
    diagonal = np.diag(matrix)
    if not np.all(diagonal > 0.0):
        raise linalg.LinAlgError("a diagonal entry is zero or negative")
    scale = np.sqrt(diagonal)
    return linalg.cholesky(matrix / np.outer(scale, scale), lower=True), scale
