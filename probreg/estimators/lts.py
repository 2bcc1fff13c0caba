"""Least trimmed squares over elemental subsets, with or without concentration steps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
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
from probreg.posterior.weighted_fit import WeightedFit
from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem, Whitened
from probreg.typing import FloatArray, IntArray


@dataclass(frozen=True)
class Lts:
    """Least sum of the smallest squared whitened residuals.

    Every subset of rows that just determines the unknowns gives a candidate; the one with
    the least trimmed sum wins. With `concentration`, the best candidates are improved by
    least squares on their own smallest residuals until these no longer change (FAST-LTS);
    without, it is the estimator of the paper.

    Parameters
    ----------
    coverage : float
        Share of the residuals in the sum, from 0.5 to 1.
    unit : {"equation", "row"}
        Residuals of single components, as in the paper, or squared norms of rows.
    subsets : int
        Number of random subsets; all of them where there are no more than that.
    concentration : bool
        Improve the ten best candidates by concentration steps.

    Raises
    ------
    InvalidInputError
        A coverage out of range, an unknown unit, fewer than one subset.

    References
    ----------
    Tian and Huang, J. Electronics & Information Technology 40(3), 2018, equations (16), (29);
    Rousseeuw and Van Driessen, Data Mining and Knowledge Discovery 12, 2006.
    """

    coverage: float = 0.75
    unit: Unit = "equation"
    subsets: int = 500
    concentration: bool = False

    takes_prior: ClassVar[bool] = False

    def __post_init__(self) -> None:
        if not 0.5 <= self.coverage <= 1.0:
            raise InvalidInputError(
                f"coverage is {self.coverage}; below 0.5 the fit may follow the outliers, above 1 "
                "there is nothing to trim."
            )
        check_unit(self.unit)
        check_subsets(self.subsets)

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Search the subsets; a nonlinear problem is linearised at its start and at the result.

        A generator is needed where there are more than `subsets` subsets. `weights` are 1 for
        residuals in the sum; `info`: "objective" (the trimmed sum) and "trimmed_rms" (its root
        mean square, not made consistent for Gaussian noise).
        """
        refuse_prior(prior, "Lts")
        search = partial(self._search, WeightedFit(problem, Gaussian()))
        return search_subsets(problem, self.subsets, rng, search)

    def _search(self, fit: WeightedFit, rows: Whitened, chosen: IntArray) -> Estimate:
        candidates = subset_solutions(rows, chosen)
        sums = np.concatenate([self._objective(rows, part) for part in parts(candidates, rows)])
        theta = candidates[np.argmin(sums)]
        if self.concentration:
            best = np.argsort(sums, kind="stable")[:10]
            improved = [self._concentrate(fit, rows, candidates[k]) for k in best]
            theta = min(improved, key=lambda t: float(self._objective(rows, t)))
        d2 = squares(rows, theta, self.unit)
        objective, kept = float(self._objective(rows, theta)), self._kept(d2.size)
        keep = np.zeros(d2.size, dtype=bool)
        keep[np.argsort(d2, kind="stable")[:kept]] = True
        info = {
            "objective": objective,
            "trimmed_rms": float(np.sqrt(objective / (kept * self._components(rows)))),
        }
        return Estimate(
            theta=theta,
            covariance=None,
            weights=unit_weights(rows, keep, self.unit),
            path=None,
            converged=True,
            info=info,
            names=fit.problem.names,
            units=fit.problem.units,
        )

    def _kept(self, residuals: int) -> int:
        return max(1, int(np.floor(self.coverage * residuals)))

    def _components(self, rows: Whitened) -> float:
        return 1.0 if self.unit == "equation" else float(rows.size.mean())

    def _objective(self, rows: Whitened, theta: FloatArray) -> FloatArray:
        d2 = squares(rows, theta, self.unit)
        kept = self._kept(d2.shape[-1])
        smallest = np.partition(d2, kept - 1, axis=-1)[..., :kept]
        return np.asarray(smallest.sum(axis=-1))

    def _concentrate(self, fit: WeightedFit, rows: Whitened, theta: FloatArray) -> FloatArray:
        last = np.inf
        for _ in range(100):
            d2 = squares(rows, theta, self.unit)
            keep = np.zeros(d2.size, dtype=bool)
            keep[np.argpartition(d2, self._kept(d2.size) - 1)[: self._kept(d2.size)]] = True
            total = float(d2[keep].sum())
            if total >= last * (1.0 - 1e-12):
                break
            last, before = total, theta
            theta = fit.solve(rows, unit_weights(rows, keep, self.unit))
        else:
            before = theta
        return before if self._objective(rows, before) <= self._objective(rows, theta) else theta
