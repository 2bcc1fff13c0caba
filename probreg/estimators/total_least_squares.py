"""Batch total least squares of lines of sight, plain and robust."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.estimators import _total
from probreg.estimators._bearings import require_bearings
from probreg.estimators._estimate import Estimate, Estimator
from probreg.estimators._subsets import refuse_prior
from probreg.noise import Gaussian, NoiseLaw, require_scalar_law
from probreg.prior import GaussianPrior
from probreg.problems.bearings import BearingProblem
from probreg.problems.linear import Problem


@dataclass(frozen=True)
class TotalLeastSquares:
    """The point X that minimises sum (H X - Z)^2 / (1 + X'X) over lines of sight.

    The bearings' noise is in H and Z alike, so plain least squares on the lines is biased;
    the smallest singular vector of [H Z] hardly is. With a noise law other than the Gaussian
    the lines are reweighted by their residuals over sigma times the distance, to convergence.

    Parameters
    ----------
    noise : NoiseLaw
    start : Estimator, optional
        Gives the first weights; by default the plain solution does.
    max_iterations : int
        Limit on reweightings.

    References
    ----------
    Wu et al., J. Central South Univ. 46(3), 2015, equations (6) to (8) and (19) to (22).
    """

    noise: NoiseLaw = field(default_factory=Gaussian)
    start: Estimator | None = None
    max_iterations: int = 200

    problem_type: ClassVar[type] = BearingProblem
    takes_prior: ClassVar[bool] = False

    def __post_init__(self) -> None:
        require_scalar_law(self.noise)
        if self.max_iterations < 1:
            raise InvalidInputError(f"max_iterations is {self.max_iterations}; 1 is the least.")

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Solve, reweight, and solve again until the weights rest.

        `covariance` is first-order and takes the noise from the residuals; `info` has
        "iterations" and "rejected", the number of lines of weight zero. A problem with a
        bearing bias is refused.
        """
        refuse_prior(prior, type(self).__name__)
        bearings = require_bearings(problem, type(self).__name__)
        bearings.observability().require()
        weights = _total.known_weights(bearings)
        if self.start is not None:
            place = self.start.estimate(bearings, None, rng).theta
            weights = _total.equivalent_weights(bearings, place, self.noise, weights)
        place, weights, iterations, settled = _total.reweight(
            bearings, self.noise, weights, self.max_iterations
        )
        info = {"iterations": iterations, "rejected": int((weights == 0.0).sum())}
        return Estimate(
            theta=place,
            covariance=_total.line_covariance(bearings, place, weights),
            weights=weights,
            path=None,
            converged=settled,
            info=info,
            names=problem.names,
            units=problem.units,
        )
