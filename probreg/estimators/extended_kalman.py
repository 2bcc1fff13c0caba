"""Extended Kalman filtering of bearings, plain and robust."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from probreg.errors import InvalidInputError, UnobservableError
from probreg.estimators._bearing_filter import (
    STATES,
    Bearings,
    Repeats,
    Taken,
    filter_bearings,
)
from probreg.estimators._bearings import in_time, require_bearings, take_first
from probreg.estimators._estimate import Estimate, in_rows
from probreg.noise import Gaussian, NoiseLaw, require_scalar_law
from probreg.prior import GaussianPrior
from probreg.problems.bearings import BearingProblem
from probreg.problems.linear import Problem
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import positive_number


@dataclass(frozen=True)
class ExtendedKalman:
    """Extended Kalman filter of an emitter's position from bearings.

    Each bearing is taken once, linearised at the prediction. With a noise law other than the
    Gaussian the update is repeated with the variance R / w, w the law's weight of what the
    update left over, (z - h(x+)) / sigma, until it settles. The settings of the paper are

    ====================  ==========================================================
    EKF                   `ExtendedKalman()`
    robust EKF            `ExtendedKalman(Igg3(1.2, 4.0))`
    chi-square gated      `ExtendedKalman(Igg3(1.2, 4.0), robust_above=7.879)`
    ====================  ==========================================================

    Parameters
    ----------
    noise : NoiseLaw
    robust_above : float, optional
        The repeated update runs only where innovation^2 exceeds this many times its
        variance; by default always.
    start_bearings : int
        Without a prior, the filter starts from equal-weight least squares on the lines of
        sight of this many bearings, and goes on with the next.
    start_sd : float
        Standard deviation of that start along x and along y, metres.
    reuse_start : bool
        Filter the bearings of the start too: the start then only says where to linearise, and
        no bearing is lost, as it is in the paper.
    acceleration : float
        Standard deviation of the emitter's random acceleration, m/s^2; it starts at rest.
        Zero is a fixed emitter. Anything above is forgetting.
    tolerance : float
        Movement of the repeated update at which it has settled, metres.
    max_passes : int
        Limit on repetitions.

    Raises
    ------
    InvalidInputError
        A setting out of range, a law with array parameters.

    References
    ----------
    Zhang, Chen, Wu and Zhang, J. Air Force Engineering Univ. 15(4), 2014, equations (4) to
    (10), with the sign of (3), the covariance of (5) and the prediction in (10) put right.
    """

    noise: NoiseLaw = field(default_factory=Gaussian)
    robust_above: float | None = None
    start_bearings: int = 5
    start_sd: float = 1000.0
    reuse_start: bool = False
    acceleration: float = 0.0
    tolerance: float = 0.01
    max_passes: int = 10

    problem_type: ClassVar[type] = BearingProblem

    def __post_init__(self) -> None:
        require_scalar_law(self.noise)
        if self.robust_above is not None:
            positive_number("robust_above", self.robust_above)
        positive_number("start_sd", self.start_sd)
        positive_number("acceleration", self.acceleration, zero=True)
        positive_number("tolerance", self.tolerance)
        if self.start_bearings < 2 or self.max_passes < 1:
            raise InvalidInputError(
                f"start_bearings is {self.start_bearings} and max_passes {self.max_passes}; at "
                "least 2 and 1 are needed."
            )

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Filter the bearings in order of time (in row order where there is none).

        The prior is the start of the filter; it is needed where the sensor's bearing bias is
        unknown. `path` follows the order in which bearings were taken, `info["order"]`; it is
        NaN until there is a start. `weights` of the start's bearings are 1. `info["passes"]`
        counts repeated updates for each filtered bearing, `info["rejected"]` bearings of weight
        zero, `info["start"]` is where the filter started.

        Raises
        ------
        InvalidInputError
            Also where the emitter came to lie on the own position.
        """
        bearings, order = in_time(require_bearings(problem, type(self).__name__))
        x, P, used = self._start(bearings, prior)
        first = self._first(used, len(bearings))
        kept = bearings_states(bearings)
        info: dict[str, Any] = {"order": order, "start": x[kept].copy(), "first": first}
        weights, info["passes"], path = self._filter(bearings, x, P, first)
        info["rejected"] = self._count_rejected(weights[first:])
        return Estimate(
            theta=x[kept],
            covariance=P[np.ix_(kept, kept)],
            weights=in_rows(weights, order),
            path=path[:, kept],
            converged=True,
            info=info,
            names=bearings.names,
            units=bearings.units,
        )

    def _first(self, used: int, n: int) -> int:
        """Number of the first bearing to filter, of n, where the start took `used`."""
        first = 0 if self.reuse_start else used
        if first >= n:
            raise UnobservableError(
                f"the start takes {used} bearings and there are {n}: none is left to filter. Set "
                "start_bearings lower or reuse_start=True."
            )
        return first

    def _filter(
        self, bearings: BearingProblem, x: FloatArray, P: FloatArray, first: int
    ) -> tuple[FloatArray, IntArray, FloatArray]:
        """Take the bearings from `first` on into x and P, in place; weights, passes, path."""
        n = len(bearings)
        weights, passes, path = np.ones(n), np.zeros(n, dtype=int), np.full((n, STATES), np.nan)
        if first:
            path[first - 1] = x
        lost = filter_bearings(
            Bearings(
                bearings.azimuth[first:],
                bearings.own_position[first:],
                bearings.sigma[first:],
                self._intervals(bearings)[first:],
                bearings.sign,
            ),
            self.noise.compiled_weight,
            self.noise.numbers,
            Repeats(self._gate(), self.max_passes, float(self.tolerance)),
            float(self.acceleration),
            x,
            P,
            Taken(weights[first:], passes[first:], path[first:]),
        )
        if lost >= 0 or not np.isfinite(x).all():
            raise InvalidInputError(
                f"the filter lost the emitter at bearing {first + max(lost, 0)}: its estimate "
                "came to lie on the own position. Start it better (start_bearings, prior)."
            )
        return weights, passes[first:], path

    def _count_rejected(self, weights: FloatArray) -> int:
        rejected = int((weights == 0.0).sum())
        if rejected == len(weights):
            raise UnobservableError(
                f"{self.noise!r} rejected all {rejected} bearings from this start, so nothing was "
                "learnt. Start nearer (start_bearings, prior)."
            )
        return rejected

    def _start(
        self, bearings: BearingProblem, prior: GaussianPrior | None
    ) -> tuple[FloatArray, FloatArray, int]:
        """State, covariance, and how many bearings were spent on them."""
        x, P = np.zeros(STATES), np.zeros((STATES, STATES))
        kept = bearings_states(bearings)
        if prior is not None:
            prior.check(bearings.names)
            x[kept], P[np.ix_(kept, kept)] = prior.mean, prior.covariance
            return x, P, 0
        if bearings.sensor_bias:
            raise InvalidInputError(
                "the filter cannot start a bearing bias from lines of sight; pass "
                "prior=GaussianPrior.from_sd(...) for position and bias."
            )
        few = take_first(bearings, self.start_bearings, "start_bearings")
        x[:2] = few.meeting_point()
        P[0, 0] = P[1, 1] = self.start_sd**2
        return x, P, self.start_bearings

    def _gate(self) -> float:
        if isinstance(self.noise, Gaussian):
            return np.inf  # its weight is one: nothing to repeat
        return -1.0 if self.robust_above is None else float(self.robust_above)

    def _intervals(self, bearings: BearingProblem) -> FloatArray:
        if bearings.time is None:
            if self.acceleration > 0.0:
                raise InvalidInputError("a moving emitter needs the times of the bearings.")
            return np.zeros(len(bearings))
        return np.diff(bearings.time, prepend=bearings.time[0])


def bearings_states(bearings: BearingProblem) -> BoolArray:
    """Which states are the problem's unknowns."""
    return np.array([True, True, False, False, bearings.sensor_bias])
