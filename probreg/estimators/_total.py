"""Total least squares of lines of sight: the criterion, its solution and covariance."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError, UnobservableError
from probreg.noise import NoiseLaw
from probreg.problems.bearings import BearingProblem
from probreg.typing import FloatArray

LENGTH_UNIT = 1e3  # the criterion (H X - Z)^2 / (1 + X'X) is posed in kilometres


def augmented(problem: BearingProblem) -> FloatArray:
    """Rows (H, Z), shape (n, 3), in units of LENGTH_UNIT."""
    if problem.sensor_bias:
        raise InvalidInputError(
            "total least squares finds a position, not a bearing bias; take Irls or LeastSquares."
        )
    H, Z = problem.line_equations()
    return np.column_stack([H, Z / LENGTH_UNIT])


def smallest_vector(d: FloatArray, weights: FloatArray) -> FloatArray:
    """Right singular vector (3,) of the smallest singular value of the weighted rows."""
    vector: FloatArray = np.linalg.svd(np.sqrt(weights)[:, None] * d)[2][2]
    return vector


def place_of(v: FloatArray) -> FloatArray:
    """Position (2,) in metres from v ~ (X; -1)."""
    if v[2] == 0.0 or not np.isfinite(v).all() or abs(v[2]) < 1e-12 * np.abs(v).max():
        raise UnobservableError(
            "the lines of sight meet at infinity only. Add bearings from other places or take "
            "an estimator with a prior."
        )
    place: FloatArray = -LENGTH_UNIT * v[:2] / v[2]
    return place


def equivalent_weights(
    problem: BearingProblem, place: FloatArray, noise: NoiseLaw, trust: FloatArray
) -> FloatArray:
    """Known weights times the law's weights of the standardised residuals, shape (n,)."""
    return trust * noise.weight(problem.line_residuals(place)[:, None], 1).reshape(len(trust))


def reweight(
    problem: BearingProblem, noise: NoiseLaw, weights: FloatArray, limit: int
) -> tuple[FloatArray, FloatArray, int, bool]:
    """Solve with the weights (n,), reweight by the law, until the weights rest.

    Returns the position, the weights at it, the reweightings, and whether they rested.
    """
    d, trust = augmented(problem), known_weights(problem)
    place = _solve(d, weights, noise)
    for step in range(1, limit + 1):
        before, weights = weights, equivalent_weights(problem, place, noise, trust)
        place = _solve(d, weights, noise)
        if np.abs(weights - before).max() < 1e-8:
            return place, weights, step, True
    return place, weights, limit, False


def _solve(d: FloatArray, weights: FloatArray, noise: NoiseLaw) -> FloatArray:
    kept = int((weights > 0.0).sum())
    if kept < 2:
        raise UnobservableError(
            f"{noise!r} rejected all but {kept} of {len(weights)} lines from this start, so "
            "nothing was learnt. Start from a robust fit or raise its threshold."
        )
    return place_of(smallest_vector(d, weights))


def known_weights(problem: BearingProblem) -> FloatArray:
    """Relative weights (n,) of bearings of different accuracy; 1 for the best."""
    weights: FloatArray = (problem.sigma.min() / problem.sigma) ** 2
    return weights


def line_covariance(
    problem: BearingProblem, place: FloatArray, weights: FloatArray
) -> FloatArray | None:
    """First-order covariance (2, 2) from the residuals themselves; None where singular.

    H is taken at the predicted bearings: at the reported ones it holds their noise.
    """
    away = place - problem.own_position
    distance = np.linalg.norm(away, axis=1)
    keep = distance > 0.0
    H = np.stack([away[keep, 1], -away[keep, 0]], axis=1) / distance[keep, None]
    rows, Z = problem.line_equations()
    left = (rows @ place - Z)[keep]
    w = weights[keep]
    normal = (H * w[:, None]).T @ H
    if np.linalg.cond(normal) > 1e14:
        return None
    bread = np.linalg.inv(normal)
    scores = H * (w * left)[:, None]
    covariance: FloatArray = bread @ (scores.T @ scores) @ bread
    return covariance
