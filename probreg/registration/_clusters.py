"""Whether errors of one target's reports hang together more than the noise law has it."""

from __future__ import annotations

import numpy as np

from probreg.noise import NoiseLaw
from probreg.problems.linear import LinearProblem
from probreg.typing import FloatArray, IntArray

FEWEST_TARGETS = 10  # below, a sum over targets says next to nothing about its own spread


def cluster_ratio(
    linear: LinearProblem,
    law: NoiseLaw,
    target: IntArray,
    theta: FloatArray,
    covariance: FloatArray,
) -> FloatArray:
    """Standard deviations by the targets' scores, relative to those of the posterior.

    The sandwich V J V with V the posterior covariance and J the sum over targets of the outer
    products of their scores: rows of one target may depend on each other in any way.

    Parameters
    ----------
    linear : LinearProblem
        Rows linearised at the mode.
    law : NoiseLaw
    target : ndarray of int, shape (rows,)
    theta : ndarray, shape (p,)
        The mode.
    covariance : ndarray, shape (p, p)
        Of the posterior.

    Returns
    -------
    ndarray, shape (p,)
        About one where rows are independent; NaN with fewer than ten targets.
    """
    known, cluster = np.unique(target, return_inverse=True)
    if len(known) < FEWEST_TARGETS:
        return np.full(len(theta), np.nan)
    rows = linear.whitened()
    residual = rows.residual(theta)
    weight = law.weight(residual, rows.size)
    weighted = residual * (weight if weight.ndim == 2 else weight[:, None])
    scores = np.einsum("nmp,nm->np", rows.A, weighted)
    summed = np.zeros((len(known), len(theta)))
    np.add.at(summed, cluster, scores)
    moved = summed @ covariance
    variance = len(known) / (len(known) - 1.0) * np.einsum("gp,gp->p", moved, moved)
    return np.asarray(np.sqrt(variance / np.diag(covariance)))
