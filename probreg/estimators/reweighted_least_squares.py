"""Rejection of large residuals of a robust fit, then least squares on the rest."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from probreg.errors import UnobservableError
from probreg.estimators._estimate import Estimate
from probreg.estimators._subsets import Unit, check_unit, refuse_prior, squares, unit_weights
from probreg.estimators.lts import Lts
from probreg.noise import Gaussian
from probreg.numerics.linalg import spd_inverse
from probreg.posterior.weighted_fit import WeightedFit
from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem
from probreg.typing import FloatArray
from probreg.validation import positive_number

# the exact fit of noise-free data leaves rounding only: 1e-6 of a standard deviation
_FLOOR = 1e-6


@dataclass(frozen=True)
class ReweightedLeastSquares:
    """Least squares on what is within `threshold` trimmed root mean squares of an LTS fit.

    It is the RLS of Tian and Huang (2018), equations (17) to (22); nothing in it is recursive.

    Parameters
    ----------
    threshold : float
        rho' of equation (20), in trimmed root mean squares of the start. For Gaussian noise
        and 75 % coverage the rms of many residuals is 1 / 1.65 of the standard deviation.
    start : Lts
        The robust fit.
    unit : {"equation", "row"}
        Reject single equations, as in the paper, or whole pairs.

    Raises
    ------
    InvalidInputError
        A threshold that is not positive, an unknown unit.
    """

    threshold: float = 3.0
    start: Lts = field(default_factory=Lts)
    unit: Unit = "equation"

    takes_prior: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive_number("threshold", self.threshold)
        check_unit(self.unit)

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Fit, reject, refit; a nonlinear problem is re-linearised with the same rows kept.

        `weights` are 1 for what was kept. `info`: "start" (its theta), "trimmed_rms", "kept",
        and "fallback", True where too little was left to determine the unknowns and theta is
        that of the start.
        """
        refuse_prior(prior, "ReweightedLeastSquares")
        fit = WeightedFit(problem, Gaussian())
        first = self.start.estimate(problem, None, rng)
        rows = problem.linearise(first.theta).whitened()
        rms = max(float(first.info["trimmed_rms"]), _FLOOR)
        components = 1.0 if self.unit == "equation" else rows.size
        keep = squares(rows, first.theta, self.unit) <= components * (self.threshold * rms) ** 2
        weights = unit_weights(rows, keep, self.unit)
        info = {"start": first.theta, "trimmed_rms": rms, "kept": int(keep.sum())}
        theta, covariance, fallback = first.theta, None, False
        try:
            theta = self._refit(problem, fit, first.theta, weights)
            rows = problem.linearise(theta).whitened()
            covariance = spd_inverse(fit.normal_matrix(rows, weights))
        except UnobservableError:
            theta, fallback = first.theta, True
        info["fallback"] = fallback
        return Estimate(
            theta=theta,
            covariance=covariance,
            weights=weights,
            path=None,
            converged=True,
            info=info,
            names=problem.names,
            units=problem.units,
        )

    def _refit(
        self, problem: Problem, fit: WeightedFit, theta: FloatArray, weights: FloatArray
    ) -> FloatArray:
        """Least squares on what is kept, re-linearised while the residuals get smaller."""
        best, last = np.inf, theta
        for _ in range(6):
            rows = problem.linearise(theta).whitened()
            v = rows.residual(theta)
            cost = float(np.sum(v**2 * (weights if weights.ndim == 2 else weights[:, None])))
            if not problem.linear and cost > 2.0 * best:
                return last  # diverging: these rows agree with no bias
            best, last = min(best, cost), theta
            theta = fit.solve(rows, weights)
            if problem.linear:
                break
        return theta
