"""Which noise law? Leave-one-out; and which rows are outliers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from probreg import arviz_adapter
from probreg.arviz_adapter import LeaveOneOut
from probreg.errors import InvalidInputError
from probreg.noise import Contaminated
from probreg.samplers import Draws
from probreg.typing import FloatArray

BAD_K = 0.7


class Ranked(NamedTuple):
    """A noise law's place among those compared.

    Attributes
    ----------
    name : str
    elpd : float
        Expected log predictive density, summed over rows.
    behind : float
        How far below the best.
    standard_error : float
        Of `behind`, from the rows' differences; 0 for the best.
    bad_rows : int
        Rows whose Pareto k exceeds 0.7: their terms are unreliable.
    """

    name: str
    elpd: float
    behind: float
    standard_error: float
    bad_rows: int


def leave_one_out(draws: Draws) -> LeaveOneOut:
    """PSIS-LOO of a posterior, a row (pair) at a time.

    Raises
    ------
    InvalidInputError
        Draws that are not from the posterior (gamma other than 1).
    """
    _require_posterior(draws)
    x = draws.posterior.free(draws.theta)
    return arviz_adapter.leave_one_out(draws.posterior.log_likelihood(x))


def _require_posterior(draws: Draws) -> None:
    if draws.gamma != 1.0:
        raise InvalidInputError(
            f"gamma = {draws.gamma:g}: these draws are not from the posterior, so they predict "
            "nothing. Sample with gamma = 1."
        )


def compare_laws(draws: Mapping[str, Draws]) -> list[Ranked]:
    """Rank noise laws by leave-one-out, best first.

    Parameters
    ----------
    draws : mapping of str to Draws
        Of posteriors that differ in the law (or prior) and not in the rows. Polar reports
        enter each in the linear form at its own mode, a small difference.

    Raises
    ------
    InvalidInputError
        Fewer than two, or different rows.
    """
    if len(draws) < 2:
        raise InvalidInputError("at least two laws are needed for a comparison.")
    _require_same_rows(draws)
    found = {name: leave_one_out(d) for name, d in draws.items()}
    order = sorted(found, key=lambda name: -found[name].elpd)
    best = found[order[0]]
    ranked = []
    for name in order:
        gap = best.pointwise - found[name].pointwise
        error = float(np.sqrt(gap.size * np.var(gap))) if name != order[0] else 0.0
        bad = int((found[name].pareto_k > BAD_K).sum())
        ranked.append(Ranked(name, found[name].elpd, float(gap.sum()), error, bad))
    return ranked


def _require_same_rows(draws: Mapping[str, Draws]) -> None:
    """Raise unless all posteriors have the same reports and scale matrices, in the same units."""
    problems = {name: d.posterior.problem for name, d in draws.items()}
    first_name, first = next(iter(problems.items()))
    at = first.linearise(first.start)
    for name, problem in problems.items():
        same = problem is first
        if not same and problem.names == first.names:
            other = problem.linearise(first.start)
            same = (
                other.y.shape == at.y.shape
                and np.allclose(other.y, at.y, rtol=1e-9)
                and np.allclose(other.R, at.R, rtol=1e-9)
            )
        if not same:
            raise InvalidInputError(
                f"the posteriors {first_name!r} and {name!r} have different rows: densities of "
                "different data, or of other units, cannot be compared."
            )


def outlier_probability(draws: Draws, chunk: int = 200) -> FloatArray:
    """Posterior probability that each row is an outlier, (n,), or (n, M) component-wise.

    Parameters
    ----------
    draws : Draws
        Under the contaminated law.
    chunk : int
        Draws taken at once.

    Raises
    ------
    InvalidInputError
        Another law: none of its rows is marked. Draws that are not from the posterior.
    """
    posterior = draws.posterior
    _require_posterior(draws)
    if not isinstance(posterior.noise, Contaminated):
        raise InvalidInputError(
            f"{type(posterior.noise).__name__} has no outliers, only a tail; take Contaminated."
        )
    x = posterior.free(draws.flat)
    rows, total = posterior.rows, 0.0
    for a in range(0, len(x), chunk):
        part = x[a : a + chunk]
        law = posterior.law(part)
        assert isinstance(law, Contaminated)
        v = rows.residual(part[:, : posterior.dim_theta])
        total = total + law.outlier_probability(v, rows.size).sum(axis=0)
    share = np.asarray(total) / len(x)
    if posterior.noise.componentwise:  # padding is no component
        real = np.arange(share.shape[1]) < rows.size[:, None]
        return np.where(real, share, np.nan)
    return share
