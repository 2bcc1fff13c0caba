"""The Cramer-Rao bound of a registration problem."""

from __future__ import annotations

import numpy as np

from probreg.noise import Gaussian, NoiseLaw
from probreg.numerics.linalg import spd_inverse
from probreg.problems.linear import LinearProblem, Problem
from probreg.typing import FloatArray


def cramer_rao_bound(
    problem: Problem, theta: FloatArray, noise: NoiseLaw | None = None
) -> FloatArray:
    """Least covariance of an unbiased estimator, shape (p, p).

    Parameters
    ----------
    problem : Problem
        Best made from noise-free reports; otherwise B and R carry the noise of one run.
    theta : ndarray, shape (p,)
        The true unknowns, where the problem is linearised.
    noise : NoiseLaw, optional
        Law of the rows, Gaussian by default. Its information per row scales that of the
        Gaussian: `NoiseLaw.information_factor`.

    Raises
    ------
    UnobservableError
        Combinations that the data do not determine have no finite bound.
    ImproperLawError
        The law has no density, hence no information.
    """
    law = Gaussian() if noise is None else noise
    linear = problem.linearise(theta)
    linear.observability().require()
    return spd_inverse(_informations(linear, law).sum(axis=0))


def cramer_rao_path(
    problem: Problem, theta: FloatArray, noise: NoiseLaw | None = None
) -> FloatArray:
    """The bound after each row, in row order, shape (n, p, p).

    NaN until the rows so far determine every unknown. Parameters and errors as for
    `cramer_rao_bound`.
    """
    linear = problem.linearise(theta)
    linear.observability().require()
    total = np.cumsum(_informations(linear, Gaussian() if noise is None else noise), axis=0)
    path = np.full(total.shape, np.nan)
    scale = np.sqrt(np.diagonal(total[-1]))
    units = np.outer(scale, scale)
    for k, information in enumerate(total):
        if np.linalg.eigvalsh(information / units)[0] > 1e-12:
            path[k] = spd_inverse(information)
    return path


def _informations(linear: LinearProblem, law: NoiseLaw) -> FloatArray:
    """Fisher information of each row, shape (n, p, p)."""
    rows = linear.whitened()
    found = np.einsum("nmp,nmq->npq", rows.A, rows.A)
    for m in np.unique(rows.size):
        found[rows.size == m] *= law.information_factor(int(m))
    return found
