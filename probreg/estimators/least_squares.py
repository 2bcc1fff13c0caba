"""Weighted least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.estimators._estimate import Estimate
from probreg.noise import Gaussian
from probreg.posterior.weighted_fit import WeightedFit
from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem


@dataclass(frozen=True)
class LeastSquares:
    """Batch least squares weighted by R^-1, re-linearised to convergence where nonlinear.

    `covariance` is the inverse of the normal matrix: right if R is the noise covariance.
    """

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Solve the normal equations; `info`: "iterations", "relinearisations"."""
        fit = WeightedFit(problem, Gaussian(), prior)
        mode = fit.mode()
        return Estimate(
            theta=mode.theta,
            covariance=fit.laplace_covariance(mode),
            weights=mode.weights,
            path=None,
            converged=mode.converged,
            info={"iterations": mode.iterations, "relinearisations": mode.relinearisations},
            names=problem.names,
            units=problem.units,
        )
