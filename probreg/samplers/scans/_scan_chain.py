"""One compiled Metropolis-Hastings chain within one scan."""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from probreg.noise import LawNumbers
from probreg.samplers.scans._target import ScanPrior
from probreg.typing import FloatArray


class Rows(NamedTuple):
    """Whitened rows that a scan looks at.

    Attributes
    ----------
    v : ndarray, shape (n, width)
    A : ndarray, shape (n, width, d)
    size : ndarray, shape (n,)
        Real components of each row.
    """

    v: FloatArray
    A: FloatArray
    size: FloatArray


class Walk(NamedTuple):
    """How the chain moves, and what density it walks on.

    Attributes
    ----------
    box : ndarray, shape (d, 2)
        Proposals outside are rejected and the state repeated.
    share_global : float
        Share of proposals that are uniform over the box.
    step : ndarray, shape (d, d)
        Lower triangular: a local step is this times normal numbers.
    gamma : float
        Power of the density.
    sign : float
        -1 turns the rows' density upside down.
    """

    box: FloatArray
    share_global: float
    step: FloatArray
    gamma: float
    sign: float


@numba.njit(cache=True)
def run_scan(
    rng: Any,
    rows: Rows,
    kernel: Any,
    law: LawNumbers,
    prior: ScanPrior,
    walk: Walk,
    x: FloatArray,
    draws: FloatArray,
) -> int:
    """Run a chain over x (d,) from its start; writes every state into draws (n, d).

    The target is the rows' density times a prior that is flat (no centre), or Gaussian about one
    of its centres, each of which is as likely; which one is a state of the chain too. Returns
    the number of accepted proposals.
    """
    k, member, accepted = prior.centres.shape[0], 0, 0
    proposed, z = np.empty(x.size), np.empty(x.size)
    height = walk.sign * _log_rows(rows, kernel, law, x)
    height += _log_prior(prior.centres, prior.root, x, member)
    for i in range(draws.shape[0]):
        inside = _propose(rng, walk, x, z, proposed)
        other = member if k < 2 else int(rng.random() * k)
        if inside:
            level = walk.sign * _log_rows(rows, kernel, law, proposed)
            level += _log_prior(prior.centres, prior.root, proposed, other)
            if np.log(rng.random()) < walk.gamma * (level - height):
                x[:] = proposed
                member, height = other, level
                accepted += 1
        draws[i] = x
    return accepted


# a call of its own costs a fifth of a step, for the generator goes with it
@numba.njit(cache=True, inline="always")
def _propose(rng: Any, walk: Walk, x: FloatArray, z: FloatArray, proposed: FloatArray) -> bool:
    """Write a proposal; whether it lies in the box. `z` (d,) is room to work in."""
    d, box = x.size, walk.box
    everywhere = rng.random() < walk.share_global
    inside = True
    for a in range(d):
        z[a] = rng.random() if everywhere else rng.standard_normal()
    for a in range(d):
        if everywhere:
            proposed[a] = box[a, 0] + (box[a, 1] - box[a, 0]) * z[a]
        else:
            proposed[a] = x[a]
            for b in range(a + 1):
                proposed[a] += walk.step[a, b] * z[b]
        if proposed[a] < box[a, 0] or proposed[a] > box[a, 1]:
            inside = False
    return inside


@numba.njit(cache=True)
def _log_rows(rows: Rows, kernel: Any, law: LawNumbers, x: FloatArray) -> float:
    total = 0.0
    for i in range(rows.v.shape[0]):
        d2 = 0.0
        for c in range(rows.v.shape[1]):
            left = rows.v[i, c]
            for a in range(x.size):
                left -= rows.A[i, c, a] * x[a]
            d2 += left * left
        total += kernel(d2 / (law.unit * law.unit), rows.size[i], law.params)
    return total


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
