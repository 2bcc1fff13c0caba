"""The compiled extended Kalman filter for bearings, with the robust inner loop."""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from probreg.noise import LawNumbers
from probreg.sensors.geometry import azimuth_and_gradient, wrap
from probreg.typing import FloatArray, IntArray

STATES = 5  # x, y, velocity x, velocity y, bearing bias


class Bearings(NamedTuple):
    """What was seen, in order of time.

    Attributes
    ----------
    azimuth, sigma, interval : ndarray, shape (n,)
        Radians, and seconds since the bearing before.
    own : ndarray, shape (n, 2)
    sign : float
        Of the bearing bias in a bearing.
    """

    azimuth: FloatArray
    own: FloatArray
    sigma: FloatArray
    interval: FloatArray
    sign: float


class Repeats(NamedTuple):
    """When an update is repeated, and until when: see `ExtendedKalman`."""

    above: float
    most: int
    tolerance: float


class Taken(NamedTuple):
    """Of each bearing: the last weight (n,), reweighted updates (n,), the state after it (n, 5)."""

    weights: FloatArray
    passes: IntArray
    path: FloatArray


class Seen(NamedTuple):
    """A bearing from a place, its innovation, and the variances of prediction and bearing."""

    azimuth: float
    own_x: float
    own_y: float
    sigma: float
    sign: float
    innovation: float
    spread: float
    variance: float


@numba.njit(cache=True)
def filter_bearings(
    bearings: Bearings,
    weight: Any,
    law: LawNumbers,
    repeats: Repeats,
    acceleration: float,
    x: FloatArray,
    P: FloatArray,
    taken: Taken,
) -> int:
    """Run through bearings, changing the state x (5,) and its covariance P (5, 5).

    Writes what became of each bearing into `taken`. Returns the number of the bearing where the
    state came to lie on the own position, or -1.
    """
    H, PH, new = np.zeros(STATES), np.empty(STATES), np.empty(STATES)
    H[4] = sign = bearings.sign
    for i in range(bearings.azimuth.size):
        _predict(x, P, bearings.interval[i], acceleration)
        azimuth, sigma = bearings.azimuth[i], law.unit * bearings.sigma[i]
        own_x, own_y = bearings.own[i, 0], bearings.own[i, 1]
        dx, dy = x[0] - own_x, x[1] - own_y
        if dx == 0.0 and dy == 0.0:
            return i
        angle, H[0], H[1] = azimuth_and_gradient(dx, dy)
        spread = 0.0
        for a in range(STATES):
            PH[a] = P[a, 0] * H[0] + P[a, 1] * H[1] + P[a, 4] * H[4]
            spread += H[a] * PH[a]
        innovation, variance = wrap(azimuth - angle - sign * x[4]), sigma**2
        seen = Seen(azimuth, own_x, own_y, sigma, sign, innovation, spread, variance)
        w, passes = 1.0, 0
        _update(x, PH, seen, w, new)
        if innovation * innovation > repeats.above * (spread + variance):
            w, passes = _repeat(seen, weight, law, repeats, x, PH, new)
        taken.passes[i] = passes
        taken.weights[i] = w / (law.unit * law.unit)
        x[:] = new
        if w > 0.0:
            for a in range(STATES):
                for b in range(STATES):
                    P[a, b] -= PH[a] * PH[b] / (spread + variance / w)
        taken.path[i] = x
    return -1


@numba.njit(cache=True)
def _repeat(
    seen: Seen,
    weight: Any,
    law: LawNumbers,
    repeats: Repeats,
    x: FloatArray,
    PH: FloatArray,
    new: FloatArray,
) -> tuple[float, int]:
    """Repeat the update from x to `new` (5,) until it settles; its weight and the repetitions.

    H stays at the prediction; the weight is that of what the update leaves over.
    """
    w, passes = 1.0, 0
    while passes < repeats.most:
        passes += 1
        angle, _, _ = azimuth_and_gradient(new[0] - seen.own_x, new[1] - seen.own_y)
        left = wrap(seen.azimuth - angle - seen.sign * new[4]) / seen.sigma
        w = weight(left * left, 1.0, law.params)
        before_x, before_y = new[0], new[1]
        _update(x, PH, seen, w, new)
        if np.hypot(new[0] - before_x, new[1] - before_y) < repeats.tolerance:
            break
    return w, passes


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
def _update(x: FloatArray, PH: FloatArray, seen: Seen, w: float, new: FloatArray) -> None:
    """State after the update with equivalent variance R / w; without one where w is zero."""
    gain = seen.innovation / (seen.spread + seen.variance / w) if w > 0.0 else 0.0
    for a in range(STATES):
        new[a] = x[a] + gain * PH[a]
