"""Least median of squares over elemental subsets, raw and reweighted."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
from scipy.special import chdtri

from probreg.estimators._estimate import Estimate
from probreg.estimators._subsets import (
    Unit,
    check_subsets,
    check_unit,
    parts,
    refuse_prior,
    search_subsets,
    squares,
    subset_solutions,
    unit_weights,
)
from probreg.noise import Gaussian
from probreg.numerics.linalg import spd_inverse
from probreg.posterior.weighted_fit import WeightedFit
from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem, Whitened
from probreg.typing import IntArray


@dataclass(frozen=True)
class Lms:
    """Least median of squared whitened residuals, by random or exhaustive subsets of rows.

    Every subset that just determines the unknowns gives a candidate; the one with the least
    median wins ("raw"). Reweighted, it is followed by least squares on the rows within the
    97.5 % point of the chi-square law, at the scale s of the median with the small-sample
    factor 1 + 5 / (n - p).

    Parameters
    ----------
    unit : {"row", "equation"}
        What the median runs over: the squared norm of rows, or of single components.
    subsets : int
        Number of random subsets; all of them where there are no more than that.
    reweighted : bool
        Whether `theta` is the reweighted solution (with its covariance) or the raw one.

    Raises
    ------
    InvalidInputError
        Unknown unit, fewer than one subset, a prior (the median has no place for it).

    References
    ----------
    Guo et al., Control and Decision (2017), reference [12]; Rousseeuw and Leroy, Robust
    Regression and Outlier Detection, 1987.
    """

    unit: Unit = "row"
    subsets: int = 200
    reweighted: bool = True

    takes_prior: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_subsets(self.subsets)
        check_unit(self.unit)

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Search the subsets; a nonlinear problem is linearised at its start and at the result.

        A generator is needed where there are more than `subsets` subsets. `weights` are 1 for
        rows kept and 0 for rows rejected; `info`: "raw", "scale", "median", "kept".
        """
        refuse_prior(prior, "Lms")
        search = partial(self._search, WeightedFit(problem, Gaussian()))
        return search_subsets(problem, self.subsets, rng, search)

    def _search(self, fit: WeightedFit, rows: Whitened, chosen: IntArray) -> Estimate:
        p = rows.A.shape[2]
        candidates = subset_solutions(rows, chosen)
        # rows of different length are brought to one scale by the medians of their laws
        m = rows.size if self.unit == "row" else np.ones(int(rows.size.sum()))
        expected = chdtri(m, 0.5)
        medians = [
            np.median(squares(rows, part, self.unit) / expected, axis=-1)
            for part in parts(candidates, rows)
        ]
        ratios = np.concatenate(medians)
        best = int(np.argmin(ratios))
        raw = candidates[best]
        d2 = squares(rows, raw, self.unit)
        scale2 = ratios[best] * (1.0 + 5.0 / max(d2.size - p, 1)) ** 2
        keep = d2 <= chdtri(m, 0.025) * max(scale2, np.finfo(float).eps)
        weights = unit_weights(rows, keep, self.unit)
        theta, covariance = raw, None
        if self.reweighted:
            theta = fit.solve(rows, weights)
            covariance = scale2 * spd_inverse(fit.normal_matrix(rows, weights))
        info = {
            "raw": raw,
            "scale": float(np.sqrt(scale2)),
            "median": float(np.median(d2)),
            "kept": int(keep.sum()),
        }
        return Estimate(
            theta=theta,
            covariance=covariance,
            weights=weights,
            path=None,
            converged=True,
            info=info,
            names=fit.problem.names,
            units=fit.problem.units,
        )
