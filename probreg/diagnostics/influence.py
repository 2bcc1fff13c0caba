"""Influence functions: how an estimate changes when one report moves."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.estimators import Estimator
from probreg.noise import NoiseLaw
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem, Problem
from probreg.typing import FloatArray
from probreg.validation import finite_array


def empirical_influence(
    estimator: Estimator,
    problem: Problem,
    row: int,
    shifts: FloatArray,
    component: int = 0,
    prior: GaussianPrior | None = None,
    seed: int | None = None,
) -> FloatArray:
    """Change of an estimate when one component of one report moves, shape (k, p).

    Parameters
    ----------
    estimator : Estimator
        Any; it is run k + 1 times.
    problem : Problem
    row, component : int
        The report that moves: as `Problem.shifted` counts them.
    shifts : ndarray, shape (k,)
        By how much, in the report's unit.
    prior : GaussianPrior, optional
    seed : int, optional
        For estimators that draw at random: each run starts from it.

    Raises
    ------
    InvalidInputError
        A row that does not exist, or shifts that are not finite.
    """
    shifts = finite_array("shifts", shifts, (None,))
    _require_row(problem, row)

    def fit(moved: Problem) -> FloatArray:
        rng = None if seed is None else np.random.default_rng(seed)
        return estimator.estimate(moved, prior, rng).theta

    base = fit(problem)
    return np.array([fit(_moved(problem, row, component, float(by))) - base for by in shifts])


def m_influence(
    linear: LinearProblem, noise: NoiseLaw, row: int, shifts: FloatArray, component: int = 0
) -> FloatArray:
    """First-order influence of a row on the M-estimate under a noise law, shape (k, p).

    M^-1 A_row' psi(shift) with psi(v) = w(v) v and M the mean curvature for Gaussian rows,
    as if the row had no error but the shift.

    Parameters
    ----------
    linear : LinearProblem
        At the true unknowns, and best without noise in B.
    noise : NoiseLaw
    row, component : int
        Entry of y that moves.
    shifts : ndarray, shape (k,)
        By how much, in the unit of y.

    Raises
    ------
    InvalidInputError
        A row that does not exist, or shifts that are not finite.

    References
    ----------
    Wu et al., J. Central South Univ. 46(3), 2015, equations (30) to (33).
    """
    shifts = finite_array("shifts", shifts, (None,))
    _require_row(linear, row)
    rows = linear.whitened()
    # the whitened image of a unit move
    moved = _moved(linear, row, component, 1.0).whitened().v[row] - rows.v[row]
    v = shifts[:, None] * moved
    weight = noise.weight(v, int(rows.size[row]))
    psi = v * (weight if weight.ndim == 2 else weight[:, None])
    curvature = np.zeros((rows.A.shape[2],) * 2)
    for m in np.unique(rows.size):
        flat = rows.A[rows.size == m].reshape(-1, rows.A.shape[2])
        curvature += mean_curvature(noise, int(m)) * flat.T @ flat
    return np.linalg.solve(curvature, (psi @ rows.A[row]).T).T


def mean_curvature(noise: NoiseLaw, m: int) -> float:
    """E w d^2 / m over standard normal residuals: by Stein's lemma the mean slope of w v."""
    from scipy.integrate import quad  # slow to import, seldom needed
    from scipy.special import gammaln

    size = 1 if noise.componentwise else m

    def integrand(d: float) -> float:
        v = np.zeros((1, size))
        v[0, 0] = d
        w = float(np.ravel(noise.weight(v, size))[0])
        density = (size - 1) * np.log(d) - 0.5 * d**2 - gammaln(0.5 * size)
        return w * d**2 * float(np.exp(density)) * 2.0 ** (1.0 - 0.5 * size)

    corners = [c * float(np.mean(noise.unit)) for c in noise.corners]
    edges = [0.0, *sorted(c for c in corners if c < 40.0), 40.0]
    total = sum(
        quad(integrand, a, b, epsrel=1e-10, limit=200)[0] for a, b in itertools.pairwise(edges)
    )
    return float(total) / size


def _moved(problem: Any, row: int, component: int, by: float) -> Any:
    """The problem with one component moved, or an error that says there is none."""
    size = getattr(problem, "size", None) if problem.linear else None
    known = component >= 0 and (size is None or component < size[row])
    try:
        if known:
            return problem.shifted(row, component, by)
    except IndexError:
        pass
    raise InvalidInputError(f"row {row} has no component {component}; they count from 0.")


def _require_row(problem: Any, row: int) -> None:
    n = len(problem.residual(problem.start))
    if not 0 <= row < n:
        raise InvalidInputError(f"row {row} does not exist: the problem has {n} rows.")
