"""Recursive total least squares of lines of sight, plain and robust."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError, UnobservableError
from probreg.estimators import _total
from probreg.estimators._bearings import in_time, require_bearings
from probreg.estimators._estimate import Estimate, in_rows
from probreg.estimators._subsets import refuse_prior
from probreg.estimators._tls_recursion import Lines, follow_lines
from probreg.noise import Gaussian, NoiseLaw, require_law, require_scalar_law
from probreg.prior import GaussianPrior
from probreg.problems.bearings import BearingProblem
from probreg.problems.linear import Problem
from probreg.typing import FloatArray
from probreg.validation import positive_number


@dataclass(frozen=True)
class RecursiveTls:
    """Total least squares followed line by line, with one power step a line.

    For each line a trial update with its full weight gives a position; the line's residual
    there, over sigma times the distance, gives its weight; the update proper is made with
    that. The settings of the paper are

    =======  ===========================================
    RTLS     `RecursiveTls()`
    XRTLS    `RecursiveTls(reject_above=3.0)`
    RRTLS    `RecursiveTls(Igg3(1.5, 5.0))`
    =======  ===========================================

    Outliers among the first points can lock RRTLS onto a wrong line for good;
    `RecursiveTls(Igg3(1.5, 5.0), start=StudentT(1.0))` does not have that weakness.

    Bearings of different sigma have known weights, relative to the best one's (weighted
    RTLS).

    Parameters
    ----------
    noise : NoiseLaw
    reject_above : float, optional
        Lines whose residual exceeds this many standard deviations get weight zero, whatever
        the law.
    start : NoiseLaw, optional
        Law of a batch fit (`TotalLeastSquares`) of the first `start_bearings` lines; they
        then have the weights that `noise` gives them at that fit. By default, as in the
        paper, the recursion starts from nothing.
    start_bearings : int
        Used with `start` only.
    omega : float
        P0 = omega I, lengths in kilometres.

    Raises
    ------
    InvalidInputError
        A setting out of range, a law with array parameters.

    References
    ----------
    Wu et al., J. Central South Univ. 46(3), 2015, equations (9) to (16) and (23) to (29).
    """

    noise: NoiseLaw = field(default_factory=Gaussian)
    reject_above: float | None = None
    start: NoiseLaw | None = None
    start_bearings: int = 30
    omega: float = 1e8

    problem_type: ClassVar[type] = BearingProblem
    takes_prior: ClassVar[bool] = False

    def __post_init__(self) -> None:
        require_scalar_law(self.noise)
        positive_number("omega", self.omega)
        if self.reject_above is not None:
            positive_number("reject_above", self.reject_above)
        if self.start is not None:
            require_law(self.start)
        if self.start_bearings < 3:
            raise InvalidInputError(
                f"start_bearings is {self.start_bearings}; a fit that tells outliers needs at "
                "least 3."
            )

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Follow the lines in order of time (in row order where there is none).

        `path` follows the order in which lines were taken, `info["order"]`; it is NaN until
        there is a start. `info["rejected"]` counts lines of weight zero, `info["first"]` those
        of the start. `covariance` is first-order and takes the noise from the residuals. A
        problem with a bearing bias is refused.
        """
        refuse_prior(prior, type(self).__name__)
        bearings, order = in_time(require_bearings(problem, type(self).__name__))
        d, trust = _total.augmented(bearings), _total.known_weights(bearings)
        if not bearings.lines_meet:
            bearings.observability().require()
        n, first = len(bearings), 0
        weights, path = np.zeros(n), np.full((n, 2), np.nan)
        S, v = np.eye(3) / self.omega, np.array([0.0, 0.0, -1.0])
        if self.start is not None:
            first = min(self.start_bearings, n)
            v = self._start(bearings, d[:first], weights[:first], self.start)
            S += (d[:first] * weights[:first, None]).T @ d[:first]
            path[first - 1] = _total.place_of(v) / _total.LENGTH_UNIT
        own = bearings.own_position[first:] / _total.LENGTH_UNIT
        lines = Lines(d[first:], own, bearings.sigma[first:], trust[first:])
        limit = np.inf if self.reject_above is None else float(self.reject_above)
        law, weight = self.noise.numbers, self.noise.compiled_weight
        follow_lines(lines, weight, law, limit, S, v, weights[first:], path[first:])
        rejected = _count_rejected(weights)
        place = _total.place_of(v)
        return Estimate(
            theta=place,
            covariance=_total.line_covariance(bearings, place, weights),
            weights=in_rows(weights, order),
            path=path * _total.LENGTH_UNIT,
            converged=True,
            info={"order": order, "rejected": rejected, "first": first},
            names=bearings.names,
            units=bearings.units,
        )

    def _start(
        self, bearings: BearingProblem, d: FloatArray, weights: FloatArray, law: NoiseLaw
    ) -> FloatArray:
        """Weights of the first lines from the batch fit, in place; the vector they give."""
        few = bearings.part(slice(len(d)))
        trust = _total.known_weights(few)
        # from the robust start of the problem: plain total least squares may lie among outliers
        first = _total.equivalent_weights(few, few.start[:2], law, trust)
        place = _total.reweight(few, law, first, 200)[0]
        # of different accuracy, the first lines count relative to the best of all
        scale = float(bearings.sigma.min() / few.sigma.min()) ** 2
        weights[:] = scale * _total.equivalent_weights(few, place, self.noise, trust)
        if self.reject_above is not None:
            weights[np.abs(few.line_residuals(place)) > self.reject_above] = 0.0
        return _total.smallest_vector(d, weights)


def _count_rejected(weights: FloatArray) -> int:
    """Lines (n,) of weight zero.

    Raises
    ------
    UnobservableError
        All but one.
    """
    n, rejected = len(weights), int((weights == 0.0).sum())
    if n - rejected < 2:
        raise UnobservableError(
            f"all but {n - rejected} of {n} lines were rejected, so nothing was learnt. Give "
            "a robust start (start=StudentT(1.0)) or raise the threshold."
        )
    return rejected
