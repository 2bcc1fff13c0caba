"""Iteratively reweighted least squares: the mode of a problem under a noise law and a prior."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import linalg

from probreg.errors import InvalidInputError, UnobservableError
from probreg.noise import Gaussian, Hyperbolic, NoiseLaw, per_component, require_law
from probreg.numerics.linalg import spd_inverse, spd_solve
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem, Problem, Whitened
from probreg.typing import FloatArray
from probreg.validation import finite_array

_MAX_PASSES = 30  # linearisations; three or four are usual
_DIVERGED = 2.0  # growth of the objective that a change of R with the bias cannot explain


@dataclass(frozen=True, eq=False)
class Mode:
    """Where iteratively reweighted least squares came to rest.

    Attributes
    ----------
    theta : ndarray, shape (p,)
    weights : ndarray, shape (n,), or (n, M) for component-wise laws
        Equivalent weights at theta.
    linear : LinearProblem
        The linear problem tangent at theta.
    iterations, relinearisations : int
    converged : bool
    """

    theta: FloatArray
    weights: FloatArray
    linear: LinearProblem
    iterations: int
    relinearisations: int
    converged: bool


@dataclass(frozen=True, eq=False)
class WeightedFit:
    """Rows under a noise law's weights, with an optional Gaussian prior: no density is needed.

    Parameters
    ----------
    problem : Problem
        Linear or nonlinear.
    noise : NoiseLaw
        Law of the whitened residuals, proper or not.
    prior : GaussianPrior, optional
        On the unknowns; by default flat, and the data must then determine them.

    Raises
    ------
    InvalidInputError
        Not a law, not a prior, or a prior whose length does not fit.
    UnobservableError
        Without a prior: combinations that the data do not determine, by name.
    """

    problem: Problem
    noise: NoiseLaw
    prior: GaussianPrior | None = None

    def __post_init__(self) -> None:
        if self.prior is not None and not isinstance(self.prior, GaussianPrior):
            raise InvalidInputError(f"prior is {self.prior!r}; a GaussianPrior is needed.")
        require_law(self.noise)
        if self.prior is not None:
            self.prior.check(self.problem.names)
        self._at_start  # noqa: B018  refuse an undetermined problem now, not in mid-run

    @cached_property
    def linear(self) -> LinearProblem:
        """The linear problem that is tangent at the mode."""
        return self._at_start if self.problem.linear else self._mode.linear

    def mode(
        self,
        start: FloatArray | None = None,
        max_iterations: int = 500,
        tolerance: float = 1e-8,
    ) -> Mode:
        """Find a mode by iteratively reweighted least squares, re-linearising as it moves.

        Parameters
        ----------
        start : ndarray, shape (p,), optional
            By default the least-squares solution, or for laws with several modes the
            least-absolute-deviation solution.
        max_iterations : int
            Limit on reweightings at one linearisation.
        tolerance : float
            Largest last step, in posterior standard deviations.
        """
        if start is None and max_iterations == 500 and tolerance == 1e-8:
            return self._mode
        return self._find_mode(start, max_iterations, tolerance)

    def hessian(self, mode: Mode) -> FloatArray:
        """Minus the second derivative (p, p) of the log-posterior at a mode."""
        rows = mode.linear.whitened()
        v = rows.residual(mode.theta)
        # wide enough that the few rows a kinked law fits exactly do not pass for its mean slope
        bandwidth = float(np.mean(self.noise.unit)) * len(v) ** (-1.0 / 5.0)
        across, along = self.noise.curvature(v, rows.size, bandwidth)
        if self.noise.componentwise:
            return self.normal_matrix(rows, along)
        length = np.linalg.norm(v, axis=1)
        direction = v / np.maximum(length, np.finfo(float).tiny)[:, None]
        radial = np.einsum("nm,nmp->np", direction, rows.A)
        return self.normal_matrix(rows, across) + (radial * (along - across)[:, None]).T @ radial

    def laplace_covariance(self, mode: Mode) -> FloatArray:
        """Inverse Hessian (p, p) at the mode.

        Raises
        ------
        InvalidInputError
            The Hessian is not positive definite: theta is not a mode.
        """
        try:
            return spd_inverse(self.hessian(mode))
        except linalg.LinAlgError as error:
            raise InvalidInputError(
                "the log-posterior is not curved downwards in every direction here, so this is "
                "no mode; start elsewhere or take a law with one mode (Hyperbolic, Huber)."
            ) from error

    def sandwich_covariance(self, mode: Mode) -> FloatArray:
        """Covariance (p, p) of the estimate whatever the law of the rows: H^-1 J H^-1.

        J sums the outer products of the rows' scores, and of the prior's, which counts as one
        more observation; rows must be independent.
        """
        rows = mode.linear.whitened()
        v = rows.residual(mode.theta)
        scores = np.einsum("nm,nmp->np", per_component(mode.weights, v) * v, rows.A)
        bread = self.laplace_covariance(mode)
        spread = scores.T @ scores
        if self.prior is not None:
            spread = spread + self.prior.root_precision.T @ self.prior.root_precision
        return bread @ spread @ bread

    def solve(self, rows: Whitened, weights: FloatArray) -> FloatArray:
        """Weighted least squares with the prior: weights (n,) or (n, M), theta (p,)."""
        return self._solve(self.normal_matrix(rows, weights), rows, weights)

    def normal_matrix(self, rows: Whitened, weights: FloatArray) -> FloatArray:
        """A'WA plus the prior precision, shape (p, p)."""
        flat = rows.A.reshape(-1, rows.A.shape[-1])
        matrix = (flat * per_component(weights, rows.v).reshape(-1, 1)).T @ flat
        if self.prior is not None:
            root = self.prior.root_precision
            matrix = matrix + root.T @ root
        return matrix

    # -- details -----------------------------------------------------------------------

    @cached_property
    def _mode(self) -> Mode:
        return self._find_mode(None, 500, 1e-8)

    @cached_property
    def _at_start(self) -> LinearProblem:
        origin = self.problem.start if self.prior is None else self.prior.mean
        linear = self.problem.linearise(origin)
        if self.prior is None:
            linear.observability().require()
        return linear

    def _find_mode(self, start: FloatArray | None, max_iterations: int, tolerance: float) -> Mode:
        if start is not None:
            theta = finite_array("start", start, (len(self.problem.names),))
        elif self.noise.convex:
            theta = self.solve(self._at_start.whitened(), np.ones(len(self._at_start.y)))
        else:
            scale = self.noise.unit if np.ndim(self.noise.unit) == 0 else 1.0
            smooth = WeightedFit(self._at_start, Hyperbolic(0.1, scale=scale), self.prior)
            theta = smooth._find_mode(None, max_iterations, 1e-2).theta
        iterations, passes, settled = 0, 0, False
        # where nonlinear steps diverge they are halved: the objective falls from pass to pass
        kept = self.problem.start if self.prior is None else self.prior.mean
        slack = _DIVERGED if self.problem.exact is None else 1.0 + 1e-9
        limit = slack * self._objective(self._at_start, kept)
        while passes < _MAX_PASSES and not settled:
            passes += 1
            linear = self.problem.linearise(theta)
            value = 0.0 if self.problem.linear else self._objective(linear, theta)
            if start is None and value > limit:
                theta = 0.5 * (kept + theta)
                continue
            kept, limit = theta, min(limit, slack * value)
            theta, weights, steps, rested = self._reweight(linear, theta, max_iterations, tolerance)
            iterations += steps
            matrix = self.normal_matrix(linear.whitened(), weights)
            settled = self.problem.linear or _rests(theta, kept, matrix, max(tolerance, 1e-5))
        if not iterations:
            raise UnobservableError(
                "no step from the start makes the residuals smaller: these rows agree with no "
                "bias. Are the reports paired with the right targets?"
            )
        if not settled:  # the last step was not judged: stay where the objective is known
            theta, linear = kept, self.problem.linearise(kept)
            rows = linear.whitened()
            weights = self.noise.weight(rows.residual(theta), rows.size)
        return Mode(theta, weights, linear, iterations, passes, settled and rested)

    def _objective(self, linear: LinearProblem, theta: FloatArray) -> float:
        """Minus the log kernels of the rows, and of the prior, up to a constant."""
        rows = linear.whitened()
        d2, size = self.noise.squared_norm(rows.residual(theta), rows.size)
        value = -float(np.sum(self.noise.log_kernel(d2, size)))
        if self.prior is not None:
            away = self.prior.root_precision @ (theta - self.prior.mean)
            value += 0.5 * float(away @ away)
        return value

    def _reweight(
        self, linear: LinearProblem, theta: FloatArray, limit: int, tolerance: float
    ) -> tuple[FloatArray, FloatArray, int, bool]:
        rows = linear.whitened()
        weights = self.noise.weight(rows.residual(theta), rows.size)
        for step in range(1, limit + 1):
            matrix = self.normal_matrix(rows, weights)
            before, theta = theta, self._solve(matrix, rows, weights)
            weights = self.noise.weight(rows.residual(theta), rows.size)
            if isinstance(self.noise, Gaussian) or _rests(theta, before, matrix, tolerance):
                return theta, weights, step, True
        return theta, weights, limit, False

    def _solve(self, matrix: FloatArray, rows: Whitened, weights: FloatArray) -> FloatArray:
        weighted = per_component(weights, rows.v) * rows.v
        right = rows.A.reshape(-1, rows.A.shape[-1]).T @ weighted.ravel()
        if self.prior is not None:
            root = self.prior.root_precision
            right = right + root.T @ (root @ self.prior.mean)
        try:
            return spd_solve(matrix, right)
        except linalg.LinAlgError as error:
            raise UnobservableError(
                "the rows that keep weight do not determine the unknowns. If the noise law "
                "rejects rows, it rejects too much from this start: start from a robust fit (Lms, "
                "Hyperbolic) or raise its threshold. Otherwise add targets or give a prior."
            ) from error


def _rests(new: FloatArray, old: FloatArray, precision: FloatArray, tolerance: float) -> bool:
    """Whether a step is short, in standard deviations, or no more than rounding."""
    step = new - old
    if bool(np.all(np.abs(step) <= 4.0 * np.finfo(float).eps * np.abs(new))):
        return True
    return float(np.sqrt(max(float(step @ precision @ step), 0.0))) < tolerance
