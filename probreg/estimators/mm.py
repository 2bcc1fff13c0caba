"""MM-estimation: a robust start and scale, then an efficient redescending fit."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq

from probreg.estimators._estimate import Estimate
from probreg.estimators._subsets import refuse_prior, squares
from probreg.estimators.irls import Irls
from probreg.estimators.lts import Lts
from probreg.noise import Tukey
from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem
from probreg.typing import FloatArray
from probreg.validation import positive_number

_FLOOR = 1e-6  # of a declared standard deviation; noise-free data leave rounding only
_SCALE_C = 1.5476  # with this bisquare, half of the largest loss is the mean under the Gaussian


@dataclass(frozen=True)
class Mm:
    """Tukey bisquare on equations, from an LTS start and at the M-scale of its residuals.

    Parameters
    ----------
    c : float
        Rejection point in scales; 4.685 is 95 % efficient for Gaussian noise.
    start : Lts
        The robust fit, by default with concentration steps.

    References
    ----------
    Yohai, Annals of Statistics 15, 1987.
    """

    c: float = 4.685
    start: Lts = field(default_factory=lambda: Lts(concentration=True))

    takes_prior: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive_number("c", self.c)

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Fit the start, its scale, then the bisquare: `info` of `Irls`, "scale" and "start"."""
        refuse_prior(prior, "Mm")
        first = self.start.estimate(problem, None, rng)
        rows = problem.linearise(first.theta).whitened()
        scale = bisquare_scale(squares(rows, first.theta, "equation"), rows.A.shape[2])
        law = Tukey(self.c, scale=scale, componentwise=True)
        fit = Irls(law, start=_Given(first)).estimate(problem, None, rng)
        return replace(fit, info={**fit.info, "scale": scale, "start": first.theta})


@dataclass(frozen=True)
class _Given:
    """An estimator that returns what is known already."""

    known: Estimate

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        return self.known


def bisquare_scale(d2: FloatArray, parameters: int) -> float:
    """M-scale with breakdown point one half: mean loss = 1/2 of its maximum.

    Parameters
    ----------
    d2 : ndarray, shape (k,)
        Squared residuals.
    parameters : int
        Number of fitted parameters: the mean is taken over k minus as many, which keeps the
        scale of small samples from shrinking.
    """
    law = Tukey(_SCALE_C)
    top = _SCALE_C**2 / 6.0
    dof = max(d2.size - parameters, 1)

    def excess(log_scale: float) -> float:
        loss = -law.log_kernel(d2 / np.exp(2.0 * log_scale), 1)
        return float(loss.sum()) / (dof * top) - 0.5

    low, high = np.log(_FLOOR), 0.5 * np.log(max(float(d2.max()), _FLOOR**2)) + 8.0
    if excess(low) <= 0.0:
        return _FLOOR  # an exact fit of more than half of the data
    return float(np.exp(brentq(excess, low, high)))
