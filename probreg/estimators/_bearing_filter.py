"""The compiled extended Kalman filter for bearings, with the robust inner loop."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from probreg.sensors.geometry import azimuth_and_gradient, wrap
from probreg.typing import FloatArray, IntArray

STATES = 5  # x, y, velocity x, velocity y, bearing bias


@numba.njit(cache=True)
def filter_bearings(
    azimuth: FloatArray,
    own: FloatArray,
    sigma: FloatArray,
    interval: FloatArray,
    sign: float,
    weight: Any,
    params: FloatArray,
    unit: float,
    acceleration: float,
    robust_above: float,
    passes_allowed: int,
    tolerance: float,
    x: FloatArray,
    P: FloatArray,
    weights: FloatArray,
    passes: IntArray,
    path: FloatArray,
) -> int:
    """Run through bearings (n,), changing the state x (5,) and its covariance P (5, 5).

    Writes the last weight and the number of reweighted updates of each row, and x after it
    into path (n, 5). Returns the number of the row where the state came to lie on the own
    position, or -1.
    """
    H, PH, new = np.zeros(STATES), np.empty(STATES), np.empty(STATES)
    for i in range(azimuth.size):
        _predict(x, P, interval[i], acceleration)
        dx, dy = x[0] - own[i, 0], x[1] - own[i, 1]
        if dx == 0.0 and dy == 0.0:
            return i
        angle, H[0], H[1] = azimuth_and_gradient(dx, dy)
        H[4] = sign
        innovation = wrap(azimuth[i] - angle - sign * x[4])
        spread = 0.0
        for a in range(STATES):
            PH[a] = P[a, 0] * H[0] + P[a, 1] * H[1] + P[a, 4] * H[4]
            spread += H[a] * PH[a]
        variance = (unit * sigma[i]) ** 2
        w, passes[i] = 1.0, 0
        _update(x, PH, innovation, spread, variance, w, new)
        if innovation * innovation > robust_above * (spread + variance):
            # H stays at the prediction; the weight is that of what the update leaves over
            while passes[i] < passes_allowed:
                passes[i] += 1
                angle, _, _ = azimuth_and_gradient(new[0] - own[i, 0], new[1] - own[i, 1])
                left = wrap(azimuth[i] - angle - sign * new[4]) / (unit * sigma[i])
                w = weight(left * left, 1.0, params)
                before_x, before_y = new[0], new[1]
                _update(x, PH, innovation, spread, variance, w, new)
                if np.hypot(new[0] - before_x, new[1] - before_y) < tolerance:
                    break
        weights[i] = w / (unit * unit)
        x[:] = new
        if w > 0.0:
            for a in range(STATES):
                for b in range(STATES):
                    P[a, b] -= PH[a] * PH[b] / (spread + variance / w)
        path[i] = x
    return -1


@numba.njit(cache=True)
def _predict(x: FloatArray, P: FloatArray, dt: float, acceleration: float) -> None:
    """Constant velocity over dt, driven by a random acceleration that is constant over dt."""
    if dt == 0.0 or (acceleration == 0.0 and P[2, 2] == 0.0 and P[3, 3] == 0.0):
        return  # at rest: nothing moves, nothing spreads
    for k in range(2):
        x[k] += dt * x[k + 2]
        P[k, :] += dt * P[k + 2, :]
    for k in range(2):
        P[:, k] += dt * P[:, k + 2]
        q = acceleration * acceleration
        P[k, k] += q * dt**4 / 4.0
        P[k, k + 2] += q * dt**3 / 2.0
        P[k + 2, k] += q * dt**3 / 2.0
        P[k + 2, k + 2] += q * dt * dt


@numba.njit(cache=True)
def _update(
    x: FloatArray,
    PH: FloatArray,
    innovation: float,
    spread: float,
    variance: float,
    w: float,
    new: FloatArray,
) -> None:
    """State after the update with equivalent variance R / w; without one where w is zero."""
    gain = innovation / (spread + variance / w) if w > 0.0 else 0.0
    for a in range(STATES):
        new[a] = x[a] + gain * PH[a]
