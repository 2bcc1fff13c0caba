"""Elemental subsets: the candidates of the high-breakdown estimators."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from math import comb
from typing import Literal

import numpy as np

from probreg.errors import InvalidInputError
from probreg.estimators._estimate import Estimate
from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem, Whitened
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import whole_number

Unit = Literal["row", "equation"]
_CHUNK = 4_000_000  # residuals held at once


def required_subsets(wrong_share: float, rows: int, probability: float = 0.99) -> int:
    """Number of random subsets of which one is clean with the given probability.

    One clean subset need not be a well-conditioned one: with few pairs take all subsets.

    Parameters
    ----------
    wrong_share : float
        Share of wrong pairs p_e, in [0, 1).
    rows : int
        Pairs in a subset, m.
    probability : float
        P0, in (0, 1).

    Raises
    ------
    InvalidInputError
        A share or probability out of range, or fewer than one row.

    References
    ----------
    Tian and Huang, J. Electronics & Information Technology 40(3), 2018, equation (25).
    """
    if not (0.0 <= wrong_share < 1.0 and 0.0 < probability < 1.0 and rows >= 1):
        raise InvalidInputError(
            f"required_subsets({wrong_share}, {rows}, {probability}): the share must lie in "
            "[0, 1), the probability in (0, 1), and a subset holds at least one row."
        )
    clean = (1.0 - wrong_share) ** rows
    if clean == 1.0:
        return 1
    return max(1, int(np.ceil(np.log1p(-probability) / np.log1p(-clean))))


def elemental_subsets(rows: Whitened, limit: int, rng: np.random.Generator | None) -> IntArray:
    """Row numbers (k, r) of subsets that just determine the unknowns: all, or `limit` at random.

    Raises
    ------
    InvalidInputError
        Too few rows, or random subsets asked for without a generator.
    """
    n, _, p = rows.A.shape
    m = int(rows.size.min())
    needed = -(-p // m)
    if n < needed:
        raise InvalidInputError(
            f"{n} rows of {m} equations cannot give a subset that determines {p} unknowns."
        )
    if comb(n, needed) <= limit:
        return np.array(list(combinations(range(n), needed)))
    if rng is None:
        raise InvalidInputError(
            f"{comb(n, needed)} subsets are too many to try; pass a Generator "
            "(numpy.random.default_rng(seed)) so that they can be drawn."
        )
    return np.stack([rng.choice(n, needed, replace=False) for _ in range(limit)])


def search_subsets(
    problem: Problem,
    limit: int,
    rng: np.random.Generator | None,
    find: Callable[[Whitened, IntArray], Estimate],
) -> Estimate:
    """Search the subsets of a problem linearised at its start, if nonlinear at the result again."""
    rows = problem.linearise(problem.start).whitened()
    chosen = elemental_subsets(rows, limit, rng)
    result = find(rows, chosen)
    if problem.linear:
        return result
    return find(problem.linearise(result.theta).whitened(), chosen)


def refuse_prior(prior: GaussianPrior | None, name: str) -> None:
    """Raise if a prior is given: a median or a trimmed sum has no place for it."""
    if prior is not None:
        raise InvalidInputError(
            f"{name} takes no prior; use Irls(noise, start={name}()) with the prior."
        )


def subset_solutions(rows: Whitened, chosen: IntArray) -> FloatArray:
    """Least-squares solutions of subsets of rows (k, r), shape (k, p)."""
    p = rows.A.shape[2]
    scale = np.linalg.norm(rows.A.reshape(-1, p), axis=0)
    A = (rows.A[chosen] / scale).reshape(len(chosen), -1, p)
    v = rows.v[chosen].reshape(len(chosen), -1, 1)
    return (np.linalg.pinv(A) @ v)[..., 0] / scale


def squares(rows: Whitened, theta: FloatArray, unit: Unit) -> FloatArray:
    """Squared residuals of rows (..., n) or of their real components (..., sum of sizes)."""
    v = rows.residual(theta)
    if unit == "row":
        return np.einsum("...nm,...nm->...n", v, v)
    return v[..., real(rows)] ** 2


def real(rows: Whitened) -> BoolArray:
    """Which components of padded rows are real, shape (n, M)."""
    return np.arange(rows.v.shape[1]) < rows.size[:, None]


def unit_weights(rows: Whitened, keep: BoolArray, unit: Unit) -> FloatArray:
    """Weights 0 and 1 of rows (n,), or of components (n, M), from what `squares` lists."""
    if unit == "row":
        return keep.astype(float)
    weights = np.zeros(rows.v.shape)
    weights[real(rows)] = keep
    return weights


def parts(candidates: FloatArray, rows: Whitened) -> list[FloatArray]:
    """Cut candidates so that their residuals fit in memory."""
    length = max(1, _CHUNK // rows.v.size)
    return [candidates[a : a + length] for a in range(0, len(candidates), length)]


def check_unit(unit: str) -> None:
    """Raise unless the unit is known."""
    if unit not in ("row", "equation"):
        raise InvalidInputError(f"unit is {unit!r}; take 'row' or 'equation'.")


def check_subsets(subsets: int) -> None:
    """Raise unless the number of subsets is a whole number above zero."""
    whole_number("subsets", subsets)
