"""Velocities of rows, steadied by those of the same target before and after."""

from __future__ import annotations

import numba
import numpy as np

from probreg.typing import FloatArray, IntArray

_BESIDE = 4  # rows before and after


@numba.njit(cache=True)
def steady(
    target: IntArray, time: FloatArray, velocity: FloatArray, weight: FloatArray, reach: float
) -> FloatArray:
    """Weighted median velocity (n, d) of neighbouring rows of the same target.

    A row of short span hardly knows its own velocity; taken as a sensitivity to a clock's
    offset, that noise would pass for information. A median also bears rows with a wrong report.

    Parameters
    ----------
    target, time : ndarray, shape (n,)
        Sorted by target, then time.
    velocity : ndarray, shape (n, d)
    weight : ndarray, shape (n,)
        Inverse variance of each, up to a factor.
    reach : float
        Longest time to a neighbour, seconds.
    """
    n, d = velocity.shape
    out = np.empty((n, d))
    for i in range(n):
        a, b = i, i + 1
        while a > 0 and i - a < _BESIDE and target[a - 1] == target[i]:
            if time[i] - time[a - 1] > reach:
                break
            a -= 1
        while b < n and b - i <= _BESIDE and target[b] == target[i]:
            if time[b] - time[i] > reach:
                break
            b += 1
        for c in range(d):
            order = np.argsort(velocity[a:b, c])
            half, total = 0.5 * weight[a:b].sum(), 0.0
            for k in order:
                total += weight[a + k]
                if total >= half:
                    out[i, c] = velocity[a + k, c]
                    break
    return out
