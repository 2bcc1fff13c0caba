"""The Cramer-Rao bound of a registration problem."""

from __future__ import annotations

import numpy as np

from probreg.noise import Gaussian, NoiseLaw
from probreg.posterior import spd_inverse
from probreg.problem import Problem
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
    rows = linear.whitened()
    information = np.zeros((rows.A.shape[-1],) * 2)
    for m in np.unique(rows.size):
        flat = rows.A[rows.size == m].reshape(-1, rows.A.shape[-1])
        information += law.information_factor(int(m)) * flat.T @ flat
    return spd_inverse(information)
