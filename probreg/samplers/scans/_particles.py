"""One scan of many Kalman filters that differ in the precisions of their rows, compiled."""

from __future__ import annotations

import numba
import numpy as np

from probreg.numerics.kalman import take_in
from probreg.typing import FloatArray


@numba.njit(cache=True)
def predict(x: FloatArray, P: FloatArray, F: FloatArray, Q: FloatArray) -> None:
    """Move every particle's mean (N, d) and covariance (N, d, d) one step on, in place."""
    for i in range(x.shape[0]):
        x[i] = F @ x[i]
        P[i] = F @ P[i] @ F.T + Q


@numba.njit(cache=True)
def update(
    x: FloatArray, P: FloatArray, v: FloatArray, A: FloatArray, precision: FloatArray
) -> FloatArray:
    """Take in a scan of whitened components v (m,), slopes A (m, d), precisions (N, m).

    Changes x and P in place; returns the log predictive density (N,).
    """
    N, d = x.shape
    heights, gain = np.empty(N), np.empty(d)
    for i in range(N):
        heights[i] = take_in(x[i], P[i], v, A, precision[i], gain)
    return heights
