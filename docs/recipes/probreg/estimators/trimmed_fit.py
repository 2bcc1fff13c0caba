"""Least squares on what a robust fit leaves: hard trimming in one step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.estimators._estimate import Estimate
from probreg.noise import HardReject, Hyperbolic
from probreg.posterior import WeightedFit
from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem


@dataclass(frozen=True)
class TrimmedFit:
    """Least absolute deviation, then least squares without rows beyond a limit.

    Parameters
    ----------
    limit : float
        Whitened distance beyond which a row is left out.
    """

    limit: float = 4.0

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Fit twice; `info` has "rejected", the number of rows left out."""
        start = WeightedFit(problem, Hyperbolic(), prior).mode().theta
        fit = WeightedFit(problem, HardReject(self.limit), prior)
        mode = fit.mode(start)
        return Estimate(
            theta=mode.theta,
            covariance=fit.laplace_covariance(mode),
            weights=mode.weights,
            path=None,
            converged=mode.converged,
            info={"rejected": int((mode.weights == 0.0).sum())},
            names=problem.names,
            units=problem.units,
        )
