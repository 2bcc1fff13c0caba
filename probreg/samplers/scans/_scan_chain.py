"""One compiled Metropolis-Hastings chain within one scan."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from probreg.typing import FloatArray, IntArray


@numba.njit(cache=True)
def run_scan(
    rng: Any,
    v: FloatArray,
    A: FloatArray,
    size: FloatArray,
    kernel: Any,
    params: FloatArray,
    unit: float,
    sign: float,
    centres: FloatArray,
    prior_root: FloatArray,
    box: FloatArray,
    share_global: float,
    step: FloatArray,
    gamma: float,
    x: FloatArray,
    member: int,
    draws: FloatArray,
    members: IntArray,
) -> int:
    """Run a chain over x (d,) from its start; writes every state into draws (n, d).

    The target is the rows' density, v (n, width), A (n, width, d) of which `size` (n,) components
    of each row are real, times a prior that is flat (no centre), or Gaussian about one of the
    centres (k, d), each of which is as likely; which one is a state of the chain too (`member`).
    `prior_root` whitens it.
    A local step is `step` (d, d), lower triangular, times normal numbers.
    Proposals outside the box (d, 2) are rejected and the state repeated. `sign` -1 turns the
    rows' density upside down. Returns the number of accepted proposals.
    """
    d, k = x.size, centres.shape[0]
    proposed, z = np.empty(d), np.empty(d)
    height = _log_target(v, A, size, kernel, params, unit, sign, x)
    height += _log_prior(centres, prior_root, x, member)
    accepted = 0
    for i in range(draws.shape[0]):
        everywhere = rng.random() < share_global
        inside = True
        for a in range(d):
            z[a] = rng.random() if everywhere else rng.standard_normal()
        for a in range(d):
            if everywhere:
                proposed[a] = box[a, 0] + (box[a, 1] - box[a, 0]) * z[a]
            else:
                proposed[a] = x[a]
                for b in range(a + 1):
                    proposed[a] += step[a, b] * z[b]
            if proposed[a] < box[a, 0] or proposed[a] > box[a, 1]:
                inside = False
        other = member if k < 2 else int(rng.random() * k)
        if inside:
            level = _log_target(v, A, size, kernel, params, unit, sign, proposed)
            level += _log_prior(centres, prior_root, proposed, other)
            if np.log(rng.random()) < gamma * (level - height):
                x[:] = proposed
                member, height = other, level
                accepted += 1
        draws[i] = x
        members[i] = member
    return accepted


@numba.njit(cache=True)
def _log_target(
    v: FloatArray,
    A: FloatArray,
    size: FloatArray,
    kernel: Any,
    params: FloatArray,
    unit: float,
    sign: float,
    x: FloatArray,
) -> float:
    total = 0.0
    for i in range(v.shape[0]):
        d2 = 0.0
        for c in range(v.shape[1]):
            left = v[i, c]
            for a in range(x.size):
                left -= A[i, c, a] * x[a]
            d2 += left * left
        total += kernel(d2 / (unit * unit), size[i], params)
    return sign * total


@numba.njit(cache=True)
def _log_prior(centres: FloatArray, root: FloatArray, x: FloatArray, member: int) -> float:
    if centres.shape[0] == 0:
        return 0.0
    total = 0.0
    for a in range(x.size):
        s = 0.0
        for b in range(x.size):
            s += root[a, b] * (x[b] - centres[member, b])
        total += s * s
    return -0.5 * total
