"""Linear estimation on the lines of sight: bearing least squares, batch and recursive."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from probreg.estimators._bearings import require_bearings
from probreg.estimators._estimate import Estimate, Estimator
from probreg.estimators.least_squares import LeastSquares
from probreg.prior import GaussianPrior
from probreg.problems.bearings import BearingProblem
from probreg.problems.linear import Problem
from probreg.typing import FloatArray


@dataclass(frozen=True)
class LinesOfSight:
    """Any estimator of linear problems, on the lines of sight with equal weights.

    `LinesOfSight()` is bearing least squares, `LinesOfSight(Recursive(Gaussian(), 1e8))` its
    recursion. The bearings' noise is in both sides of the equations, so the estimate is
    biased towards the track; the covariance is for rows of unit standard deviation (`spread`)
    and is not to be trusted.

    Parameters
    ----------
    estimator : Estimator
    spread : float
        Standard deviation of a row, metres: sigma times the distance.

    References
    ----------
    Wu et al., J. Central South Univ. 46(3), 2015, equations (3) and (5).
    """

    estimator: Estimator = field(default_factory=LeastSquares)
    spread: FloatArray | float = 1.0

    problem_type: ClassVar[type] = BearingProblem

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Estimate the position from the lines of sight, as the estimator does."""
        bearings = require_bearings(problem, type(self).__name__)
        return self.estimator.estimate(bearings.lines(self.spread), prior, rng)
