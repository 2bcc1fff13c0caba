"""Batch M-estimation and maximum likelihood by iteratively reweighted least squares."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from probreg.errors import InvalidInputError
from probreg.estimators._estimate import Estimate, Estimator
from probreg.noise import Hyperbolic, NoiseLaw, require_scalar_law
from probreg.posterior.weighted_fit import WeightedFit
from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Irls:
    """The mode under any noise law, to convergence.

    With `Hyperbolic` it is batch least absolute deviation (Guo et al. 2017, equation 9);
    with `StudentT` and `Contaminated` maximum likelihood by EM; with `Huber`, `Tukey`, ... an
    M-estimate. `covariance` is the sandwich, which does not trust the law.

    Parameters
    ----------
    noise : NoiseLaw
        Its equivalent weight is the reweighting.
    start : Estimator, optional
        Gives the starting point. By default least squares, or least absolute deviation for
        laws with several modes.
    max_iterations : int
        Limit on reweightings at one linearisation.
    tolerance : float
        Largest last step, in standard deviations of the estimate.

    Raises
    ------
    InvalidInputError
        A law with array parameters.
    """

    noise: NoiseLaw = field(default_factory=Hyperbolic)
    start: Estimator | None = None
    max_iterations: int = 500
    tolerance: float = 1e-8

    def __post_init__(self) -> None:
        require_scalar_law(self.noise)

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Reweight to convergence.

        `info`: "iterations", "relinearisations" and "laplace_covariance", the covariance if the
        law is right (None where the loss is not curved in every direction).
        """
        fit = WeightedFit(problem, self.noise, prior)
        at = None
        if self.start is not None:
            known = prior if getattr(self.start, "takes_prior", True) else None
            at = self.start.estimate(problem, known, rng).theta
        mode = fit.mode(at, self.max_iterations, self.tolerance)
        laplace: FloatArray | None = None
        sandwich: FloatArray | None = None
        with suppress(InvalidInputError):  # a loss not curved in every direction claims nothing
            laplace = fit.laplace_covariance(mode)
            sandwich = fit.sandwich_covariance(mode)
        info = {
            "iterations": mode.iterations,
            "relinearisations": mode.relinearisations,
            "laplace_covariance": laplace,
        }
        return Estimate(
            theta=mode.theta,
            covariance=sandwich,
            weights=mode.weights,
            path=None,
            converged=mode.converged,
            info=info,
            names=problem.names,
            units=problem.units,
        )
