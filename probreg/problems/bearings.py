"""Bearings-only location: one moving observer, an emitter at rest, no range."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.problems import _sightlines
from probreg.problems.linear import LinearProblem, bias_scale
from probreg.problems.observability import Observability, observability_of
from probreg.sensors import geometry
from probreg.sensors.reports import BearingReports
from probreg.typing import FloatArray, IntArray
from probreg.validation import (
    angle_sigma,
    finite_array,
    positive_number,
    refuse_degrees,
)

_ADVICE = "The own ship must move across the line of sight: add bearings from other places,"


@dataclass(frozen=True, eq=False)
class BearingRows:
    """Whitened bearing residuals, exact at any position of the emitter."""

    problem: BearingProblem

    @property
    def size(self) -> IntArray:
        """One component a row."""
        return np.ones(len(self.problem.bearing), dtype=int)

    @property
    def log_det(self) -> FloatArray:
        """Log sigma^2 of each row."""
        return 2.0 * np.log(self.problem.sigma)

    def residual(self, theta: FloatArray) -> FloatArray:
        """Whitened residuals, shape (..., n, 1), for theta (..., p)."""
        theta = np.asarray(theta, dtype=float)
        return (self.problem.angle_left(theta) / self.problem.sigma)[..., None]

    def pull_back(self, theta: FloatArray, v: FloatArray) -> FloatArray:
        """Whitened gradient of the predicted bearings at theta, transposed, on v (..., n, 1)."""
        slope = self.problem.gradient(theta)
        return np.einsum("...np,...n->...p", slope, v[..., 0] / self.problem.sigma)

    def part(self, chosen: slice) -> BearingRows:
        """Some of the rows."""
        return BearingRows(self.problem.part(chosen))


@dataclass(frozen=True, eq=False)
class BearingProblem:
    """Bearings of an emitter at rest, taken from known own positions.

    The unknowns are the emitter's position and, on request, the sensor's own bearing bias.
    Report = truth + bias + noise.

    Parameters
    ----------
    bearing : ndarray, shape (n,)
        Reported bearings, radians.
    own_position : ndarray, shape (n, 2)
        Own position at each report, metres.
    sigma : float or ndarray, shape (n,)
        Standard deviation of the bearings, radians.
    time : ndarray, shape (n,), optional
        Seconds.
    sensor_bias : bool
        Whether the bearing bias is a third unknown.
    name : str
        Sensor name, prefix of its bias.
    from_north : bool
        Whether bearings, and the bias, are counted from y (north) clockwise instead of from
        x counter-clockwise.

    Attributes
    ----------
    names, units : tuple of str
        "emitter.x", "emitter.y" in m (and "sensor.bearing" in rad).

    Raises
    ------
    InvalidInputError
        Mismatched shapes, NaN or infinity, no bearing, a sigma that is not positive, angles
        that look like degrees.
    """

    bearing: FloatArray
    own_position: FloatArray
    sigma: Any  # float or array in, array inside
    time: FloatArray | None = None
    sensor_bias: bool = False
    name: str = "sensor"
    from_north: bool = False

    linear = False

    def __post_init__(self) -> None:
        bearing = finite_array("bearing", self.bearing, (None,))
        n = bearing.size
        if n == 0:
            raise InvalidInputError("there is no bearing.")
        refuse_degrees("bearing", bearing, 2.0 * np.pi)
        sigma = _each("sigma", self.sigma, n)
        for value in (sigma.min(), sigma.max()):
            angle_sigma("sigma", float(value))
        object.__setattr__(self, "bearing", bearing)
        object.__setattr__(self, "sigma", sigma)
        own = finite_array("own_position", self.own_position, (n, 2))
        object.__setattr__(self, "own_position", own)
        if self.time is not None:
            object.__setattr__(self, "time", finite_array("time", self.time, (n,)))

    @classmethod
    def of(cls, reports: BearingReports, sensor_bias: bool = False) -> BearingProblem:
        """Make the problem of reports of a described sensor."""
        sensor = reports.sensor
        return cls(
            reports.bearing,
            reports.own_position,
            sensor.sigma_bearing,
            reports.time,
            sensor_bias,
            sensor.name,
            sensor.from_north,
        )

    def __len__(self) -> int:
        return len(self.bearing)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        own = (f"{self.name}.bearing",) if self.sensor_bias else ()
        return ("emitter.x", "emitter.y", *own)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the unknowns."""
        return ("m", "m", "rad")[: len(self.names)]

    @property
    def azimuth(self) -> FloatArray:
        """Reported bearings from x, counter-clockwise, shape (n,)."""
        return geometry.azimuth_from_north(self.bearing) if self.from_north else self.bearing

    @property
    def sign(self) -> float:
        """What a positive bias does to `azimuth`: 1, or -1 where bearings turn clockwise."""
        return -1.0 if self.from_north else 1.0

    @property
    def exact(self) -> BearingRows:
        """Whitened rows that are right at any theta."""
        return BearingRows(self)

    @cached_property
    def start(self) -> FloatArray:
        """A point from which to linearise, with no bias, shape (p,).

        The one with the least absolute residuals among the least-squares meeting point of all
        lines of sight, those of pairs of lines, and points straight ahead: outliers spoil some
        of these but not all.
        """
        places = _sightlines.points_ahead(*self._views)
        if self.lines_meet:
            places = np.concatenate([places, _sightlines.meeting_points(*self._views)])
        theta = np.zeros((len(places), len(self.names)))
        theta[:, :2] = places
        cost = np.abs(self.exact.residual(theta)[..., 0]).sum(axis=-1)
        return theta[np.argmin(cost)]

    @cached_property
    def scale(self) -> FloatArray:
        """Largest distance of the start from the own positions, and 1 mrad, shape (p,)."""
        scale = bias_scale(self.units)
        scale[:2] = np.linalg.norm(self.start[:2] - self.own_position, axis=1).max()
        return scale

    @property
    def prior_sd(self) -> FloatArray:
        """Ten times the distance of the start, and 1 degree, shape (p,)."""
        sd = np.full(len(self.names), np.deg2rad(1.0))
        sd[:2] = 10.0 * self.scale[:2]
        return sd

    def part(self, chosen: slice | IntArray) -> BearingProblem:
        """The problem of some of the bearings."""
        time = None if self.time is None else self.time[chosen]
        # wrapped: a few bearings of a recording unwrapped across 2 pi must not look like degrees
        bearing, own = geometry.wrap_angle(self.bearing[chosen]), self.own_position[chosen]
        return replace(self, bearing=bearing, own_position=own, sigma=self.sigma[chosen], time=time)

    def shifted(self, row: int, component: int, by: float) -> BearingProblem:
        """The same problem with one bearing moved by `by` radians; `component` must be 0."""
        bearing = self.bearing.copy()
        if component != 0:
            raise IndexError("a bearing has one component, number 0.")
        bearing[row] += by
        return replace(self, bearing=bearing)

    def angle_left(self, theta: FloatArray) -> FloatArray:
        """Reported minus predicted azimuth, wrapped, shape (..., n), for theta (..., p)."""
        theta = np.asarray(theta, dtype=float)
        left = self.azimuth - self._predict(theta)[0]
        if self.sensor_bias:
            left = left - self.sign * theta[..., 2:]
        return geometry.wrap_angle(left)

    def gradient(self, theta: FloatArray) -> FloatArray:
        """Derivative of the predicted azimuth by theta, shape (..., n, p)."""
        _, by_x, by_y = self._predict(np.asarray(theta, dtype=float))
        own = (np.full_like(by_x, self.sign),) if self.sensor_bias else ()
        return np.stack([by_x, by_y, *own], axis=-1)

    def residual(self, theta: FloatArray) -> FloatArray:
        """Residuals (n, 1), radians counter-clockwise."""
        return self.angle_left(self._check(theta))[:, None]

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Derivative (n, 1, p) of the residuals."""
        return -self.gradient(self._check(theta))[:, None, :]

    def linearise(self, theta: FloatArray) -> LinearProblem:
        """The linear problem tangent at theta: y = residual + B theta.

        Raises
        ------
        InvalidInputError
            The emitter would be on the track, where its bearing is undefined.
        UnobservableError
            It would be so far that the bearings tell no distance.
        """
        theta = self._check(theta)
        _sightlines.require_distance(theta[:2], self.own_position, self.sigma)
        B = self.gradient(theta)
        return LinearProblem(
            self.residual(theta) + (B @ theta)[:, None],
            B[:, None, :],
            (self.sigma**2)[:, None, None],
            self.time,
            self.names,
            self.units,
            observed=self._verdict(B / self.sigma[:, None]),
        )

    def lines(self, spread: FloatArray | float = 1.0) -> LinearProblem:
        """The lines of sight as linear equations in the position: sin(a) x - cos(a) y = z.

        Least squares on them is bearing-line least squares, `Recursive(Gaussian(), 1e8)` its
        recursion. The bearings' noise is in both sides, so the solution is biased.

        Parameters
        ----------
        spread : float or ndarray, shape (n,)
            Standard deviation of a row, metres: equal for equal weights, sigma times the
            distance for Stansfield's.

        Raises
        ------
        InvalidInputError
            With a bearing bias as unknown: the lines do not hold it.
        """
        if self.sensor_bias:
            raise InvalidInputError(
                "the lines of sight are linear in the position only, not in a bearing bias; take "
                "Irls or LeastSquares on the problem itself."
            )
        H, Z = self.line_equations()
        n = len(self)
        spread = _each("spread", spread, n)
        positive_number("spread", float(spread.min()))
        return LinearProblem(
            Z[:, None],
            H[:, None, :],
            (spread**2)[:, None, None],
            self.time,
            self.names,
            self.units,
            observed=self._verdict(H / spread[:, None]),
        )

    def line_equations(self) -> tuple[FloatArray, FloatArray]:
        """H (n, 2) and Z (n,) of the lines of sight H X = Z, metres.

        References
        ----------
        Wu et al., J. Central South Univ. 46(3), 2015, equation (3), times cos(bearing).
        """
        return _sightlines.line_equations(*self._views)

    def line_residuals(self, place: FloatArray) -> FloatArray:
        """Residuals H X - Z of the lines at a position, over sigma times its distance, (n,).

        References
        ----------
        Wu et al., J. Central South Univ. 46(3), 2015, equations (17) and (27).
        """
        H, Z = self.line_equations()
        spread = self.sigma * np.linalg.norm(place - self.own_position, axis=1)
        left = H @ place - Z
        # on an own position the residual is zero, and so is the distance
        return np.divide(left, spread, out=np.zeros_like(left), where=spread > 0.0)

    def meeting_point(self) -> FloatArray:
        """Where the lines of sight meet by equal-weight least squares, (2,), metres."""
        return _sightlines.meeting_point(*self._views)

    @property
    def lines_meet(self) -> bool:
        """Whether the lines of sight turn by more than their noise explains."""
        return self._blind is None

    def observability(self, theta: FloatArray | None = None) -> Observability:
        """Singular values and unobservable combinations at theta (by default the start)."""
        return self.linearise(self.start if theta is None else theta).observability()

    # -- details -----------------------------------------------------------------------

    def _check(self, theta: FloatArray) -> FloatArray:
        return finite_array("theta", theta, (len(self.names),))

    def _predict(self, theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        away = theta[..., None, :2] - self.own_position
        found: tuple[FloatArray, FloatArray, FloatArray] = geometry.azimuth_and_gradient(
            away[..., 0], away[..., 1]
        )
        return found

    @property
    def _views(self) -> tuple[FloatArray, FloatArray]:
        return self.azimuth, self.own_position

    @cached_property
    def _blind(self) -> FloatArray | None:
        """Direction (2,) of the lines of sight if they tell no distance."""
        return _sightlines.parallel_direction(*self._views, self.sigma)

    def _verdict(self, sensitivity: FloatArray) -> Observability:
        """Observability of whitened sensitivities (n, p), and of the lines of sight."""
        found = observability_of(sensitivity, self.names)
        if found.complete and self._blind is not None:
            row = np.zeros((1, len(self.names)))
            row[0, :2] = self._blind
            found = replace(found, null_space=row)
        return replace(found, advice=_ADVICE)


def _each(name: str, value: FloatArray | float, n: int) -> FloatArray:
    """One number for all bearings, or one each, as an array (n,)."""
    if np.ndim(value) == 0:
        value = np.full(n, value)
    return finite_array(name, value, (n,))
