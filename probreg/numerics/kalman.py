"""Compiled Kalman filter, RTS smoother and simulation smoother.

Rows come whitened, so their components enter one by one as scalars of unit variance over a
weight: no matrix of a row is ever inverted, missing rows are rows of weight zero, and the
weights are what a scale mixture hides.
"""

from __future__ import annotations

import numba
import numpy as np

from probreg.typing import FloatArray

_WIDEST = 1e11  # largest variance before an update over that of the report
_TINY = 1e-13  # relative pivot below which a covariance has no spread in that direction


@numba.njit(cache=True)
def run_filter(
    v: FloatArray,
    A: FloatArray,
    weights: FloatArray,
    F: FloatArray,
    Q: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
) -> tuple[FloatArray, FloatArray, float]:
    """Filter scans v (T, m), A (T, m, d) of component weights (T, m); step k leads to scan k + 1.

    Returns means (2, T, d) and covariances (2, T, d, d) before and after each scan, and the log
    marginal likelihood of the whitened rows.
    """
    T, d = A.shape[0], A.shape[2]
    means, covariances = np.empty((2, T, d)), np.empty((2, T, d, d))
    log_likelihood = 0.0
    x, P = mean.copy(), covariance.copy()
    gain = np.empty(d)
    for t in range(T):
        if t > 0:
            x = F[t - 1] @ x
            P = F[t - 1] @ P @ F[t - 1].T + Q[t - 1]
        means[0, t] = x
        covariances[0, t] = P
        log_likelihood += take_in(x, P, v[t], A[t], weights[t], gain)
        means[1, t] = x
        covariances[1, t] = P
    return means, covariances, log_likelihood


@numba.njit(cache=True)
def take_in(
    x: FloatArray,
    P: FloatArray,
    v: FloatArray,
    A: FloatArray,
    weights: FloatArray,
    gain: FloatArray,
) -> float:
    """Update x (d,) and P (d, d) in place by components v (m,) of precisions `weights`.

    Returns their log predictive density; `gain` (d,) is room to work in. NaN where so little would
    be left of a variance that rounding would decide it.
    """
    d = x.size
    log_density = 0.0
    for c in range(v.size):
        w = weights[c]
        if w <= 0.0:
            continue
        innovation, spread = v[c], 1.0 / w
        for a in range(d):
            innovation -= A[c, a] * x[a]
            gain[a] = 0.0
            for b in range(d):
                gain[a] += P[a, b] * A[c, b]
        for a in range(d):
            spread += A[c, a] * gain[a]
        if not spread * w < _WIDEST:
            return np.nan
        log_density -= 0.5 * (np.log(2.0 * np.pi * spread) + innovation**2 / spread)
        for a in range(d):
            x[a] += gain[a] * innovation / spread
            for b in range(a + 1):
                P[a, b] -= gain[a] * gain[b] / spread
                P[b, a] = P[a, b]
    return log_density


@numba.njit(cache=True)
def run_smoother(
    F: FloatArray,
    predicted: FloatArray,
    predicted_cov: FloatArray,
    filtered: FloatArray,
    filtered_cov: FloatArray,
    smoothed: FloatArray,
    smoothed_cov: FloatArray,
    cross: FloatArray,
) -> None:
    """Rauch-Tung-Striebel pass; writes means, covariances, and Cov(x_t, x_t+1) into cross."""
    T, d = filtered.shape
    J = np.empty((d, d))
    smoothed[T - 1] = filtered[T - 1]
    smoothed_cov[T - 1] = filtered_cov[T - 1]
    for t in range(T - 2, -1, -1):
        _gain(filtered_cov[t], F[t], predicted_cov[t + 1], J)
        smoothed[t] = filtered[t] + J @ (smoothed[t + 1] - predicted[t + 1])
        change = smoothed_cov[t + 1] - predicted_cov[t + 1]
        P = filtered_cov[t] + J @ change @ J.T
        smoothed_cov[t] = 0.5 * (P + P.T)
        cross[t] = J @ smoothed_cov[t + 1]


@numba.njit(cache=True)
def backward_map(
    F: FloatArray,
    predicted_cov: FloatArray,
    filtered_cov: FloatArray,
    gains: FloatArray,
    roots: FloatArray,
) -> None:
    """What turns standard normal numbers z into deviations of a path from the smoothed mean.

    delta_t = gains_t delta_(t+1) + roots_t z_t, backwards from delta_T = roots_T z_T: writes
    gains (T - 1, d, d) and roots (T, d, d).
    """
    T, d = filtered_cov.shape[:2]
    left = np.empty((d, d))
    roots[T - 1] = semidefinite_root(filtered_cov[T - 1])
    for t in range(T - 1):
        half = _gain(filtered_cov[t], F[t], predicted_cov[t + 1], gains[t])
        for a in range(d):
            for b in range(a + 1):
                s = filtered_cov[t, a, b]
                for k in range(d):
                    s -= half[k, a] * half[k, b]
                left[a, b] = left[b, a] = s
        roots[t] = semidefinite_root(left)


@numba.njit(cache=True)
def smoothed_mean(
    gains: FloatArray, predicted: FloatArray, filtered: FloatArray, mean: FloatArray
) -> None:
    """Write the smoothed means (T, d) from the gains (T - 1, d, d) of `backward_map`."""
    T, d = filtered.shape
    mean[T - 1] = filtered[T - 1]
    for t in range(T - 2, -1, -1):
        for a in range(d):
            s = filtered[t, a]
            for b in range(d):
                s += gains[t, a, b] * (mean[t + 1, b] - predicted[t + 1, b])
            mean[t, a] = s


@numba.njit(cache=True)
def spread(gains: FloatArray, roots: FloatArray, z: FloatArray, delta: FloatArray) -> None:
    """Deviations delta (k, T, d) of k paths from standard normal numbers z (k, T, d)."""
    k, T, d = z.shape
    for i in range(k):
        for t in range(T - 1, -1, -1):
            for a in range(d):
                s = 0.0
                for b in range(a + 1):
                    s += roots[t, a, b] * z[i, t, b]
                if t < T - 1:
                    for b in range(d):
                        s += gains[t, a, b] * delta[i, t + 1, b]
                delta[i, t, a] = s


@numba.njit(cache=True)
def gather(gains: FloatArray, roots: FloatArray, slope: FloatArray, out: FloatArray) -> None:
    """The transpose of `spread`: derivatives by paths (k, T, d) to derivatives by z (k, T, d)."""
    k, T, d = slope.shape
    carried, following = np.empty(d), np.empty(d)
    for i in range(k):
        carried[:] = 0.0
        for t in range(T):
            for a in range(d):
                following[a] = slope[i, t, a]
                if t > 0:
                    for b in range(d):
                        following[a] += gains[t - 1, b, a] * carried[b]
            carried[:] = following
            for b in range(d):
                s = 0.0
                for a in range(b, d):
                    s += roots[t, a, b] * carried[a]
                out[i, t, b] = s


@numba.njit(cache=True)
def _gain(P: FloatArray, F: FloatArray, ahead: FloatArray, J: FloatArray) -> FloatArray:
    """Write J = P F' ahead^-1, with no gain along directions in which `ahead` has no spread.

    Returns L^-1 F P, with L the root of `ahead`: its square is J ahead J'.
    """
    d = P.shape[0]
    L = semidefinite_root(ahead)
    half = np.empty((d, d))
    # forward and backward substitution, column by column
    for k in range(d):
        for a in range(d):
            s = 0.0
            for b in range(d):
                s += F[a, b] * P[b, k]
            for b in range(a):
                s -= L[a, b] * half[b, k]
            half[a, k] = s / L[a, a] if L[a, a] > 0.0 else 0.0
        for a in range(d - 1, -1, -1):
            s = half[a, k]
            for b in range(a + 1, d):
                s -= L[b, a] * J[k, b]
            J[k, a] = s / L[a, a] if L[a, a] > 0.0 else 0.0
    return half


@numba.njit(cache=True)
def semidefinite_root(P: FloatArray) -> FloatArray:
    """Lower triangular root of a positive semi-definite matrix; pivots of rounding are zero."""
    d = P.shape[0]
    L = np.zeros((d, d))
    for a in range(d):
        s = P[a, a]
        for k in range(a):
            s -= L[a, k] * L[a, k]
        if s <= _TINY * P[a, a]:
            continue
        L[a, a] = np.sqrt(s)
        for b in range(a + 1, d):
            s = P[b, a]
            for k in range(a):
                s -= L[b, k] * L[a, k]
            L[b, a] = s / L[a, a]
    return L
