"""The compiled recursion of total least squares: one power step a line of sight."""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from probreg.noise import LawNumbers
from probreg.typing import FloatArray


class Lines(NamedTuple):
    """Lines of sight in the order in which they are taken.

    Attributes
    ----------
    d : ndarray, shape (n, 3)
        Augmented lines (H, Z).
    own : ndarray, shape (n, 2)
        Where each was seen from.
    sigma : ndarray, shape (n,)
        Of the bearings, radians.
    trust : ndarray, shape (n,)
        Known weights.
    """

    d: FloatArray
    own: FloatArray
    sigma: FloatArray
    trust: FloatArray


@numba.njit(cache=True)
def follow_lines(
    lines: Lines,
    weight: Any,
    law: LawNumbers,
    reject_above: float,
    S: FloatArray,
    v: FloatArray,
    weights: FloatArray,
    path: FloatArray,
) -> None:
    """Run through lines of sight, changing S (3, 3) and v (3,).

    S is the inverse of the paper's P: by the inversion lemma S + w d d' is what its (16)
    does to P, and solving with S is the power step, without the cancellation in P.
    A line's known weight is multiplied by that of its residual under a trial update. Writes
    these products (n,) and the position after each line, (n, 2).
    """
    inverse_unit2 = 1.0 / (law.unit * law.unit)
    trial, step = np.empty((3, 3)), np.empty(3)
    d, own = lines.d, lines.own
    for i in range(lines.d.shape[0]):
        _add(S, d[i], lines.trust[i], trial)
        _power_step(trial, v, step)
        x, y = -step[0] / step[2], -step[1] / step[2]
        left = d[i, 0] * x + d[i, 1] * y - d[i, 2]
        spread = lines.sigma[i] * np.hypot(x - own[i, 0], y - own[i, 1])
        w = 1.0
        # with one line the trial lies on it, or on the own position: nothing to judge by
        if spread > 0.0 and np.isfinite(spread):
            u2 = left * left / (spread * spread)
            w = weight(u2 * inverse_unit2, 1.0, law.params) * inverse_unit2
            if u2 > reject_above * reject_above:
                w = 0.0
        weights[i] = w * lines.trust[i]
        _add(S, d[i], weights[i], S)
        _power_step(S, v, v)
        path[i, 0], path[i, 1] = -v[0] / v[2], -v[1] / v[2]


@numba.njit(cache=True)
def _add(S: FloatArray, d: FloatArray, w: float, out: FloatArray) -> None:
    for a in range(3):
        for b in range(3):
            out[a, b] = S[a, b] + w * d[a] * d[b]


@numba.njit(cache=True)
def _power_step(S: FloatArray, v: FloatArray, out: FloatArray) -> None:
    """Out = S^-1 v, normalised; S is symmetric positive definite, 3 x 3."""
    L = np.linalg.cholesky(S)
    z0 = v[0] / L[0, 0]
    z1 = (v[1] - L[1, 0] * z0) / L[1, 1]
    z2 = (v[2] - L[2, 0] * z0 - L[2, 1] * z1) / L[2, 2]
    out[2] = z2 / L[2, 2]
    out[1] = (z1 - L[2, 1] * out[2]) / L[1, 1]
    out[0] = (z0 - L[1, 0] * out[1] - L[2, 0] * out[2]) / L[0, 0]
    length = np.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    for a in range(3):
        out[a] /= length
