"""Recursive estimators: one recursion, any noise law."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from probreg.errors import InvalidInputError, UnobservableError
from probreg.estimators._estimate import Estimate, in_rows
from probreg.estimators._recursion import Drift, Rows, State, Written, recurse
from probreg.motion.dynamics import Constant, Dynamics
from probreg.noise import Hyperbolic, NoiseLaw, require_scalar_law
from probreg.numerics.kalman import semidefinite_root
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem, Problem
from probreg.typing import FloatArray, IntArray
from probreg.validation import positive_number


@dataclass(frozen=True)
class Recursive:
    """Recursive reweighted least squares with the noise law's equivalent weight.

    For each row, with innovation e, L = R / w(e), W = P B' (B P B' + L)^-1:
    theta += W e, P -= W B P. The settings of the RALAD paper are

    ================  ==========================================
    RLS (EX)          `Recursive(Gaussian())`
    RALAD (28)-(32)   `Recursive(Hyperbolic(1e-3))`
    RALAD (42)        `Recursive(Hyperbolic(1e-3, 1.345))`
    Huber (36)        `Recursive(Huber(1.345, True))`
    Student-t         `Recursive(StudentT(3))`
    ================  ==========================================

    The returned covariance is the final P. It is what the method would claim; for any law
    but the Gaussian it is not the covariance of the estimate.

    Parameters
    ----------
    noise : NoiseLaw
        Its weight is evaluated once a row, at the innovation.
    omega : float
        Without a prior, the recursion starts at `problem.start` with P = omega times the
        squares of `problem.scale`: for biases zero and omega I in metres and milliradians.
    max_passes : int
        For nonlinear problems: re-linearise at the last estimate and run again, until it
        moves by less than a hundredth of a standard deviation.
    covariance_path : bool
        Keep P after each row in `info["covariance_path"]`, shape (n, p, p).
    precision : {"double", "single"}
        Floating-point type of the recursion.
    dynamics : Dynamics
        How the unknowns drift from one time to the next; by default they are constant. Under
        Gaussian noise the recursion is then the Kalman filter.
    forgetting : float
        Factor in (0, 1] by which the information of all rows before shrinks from one time
        to the next: the classic way to follow a drift whose size is not known.

    Raises
    ------
    InvalidInputError
        omega not above zero, a law with array parameters, forgetting outside (0, 1].

    References
    ----------
    Guo et al., Control and Decision (2017), equations (28) to (36) and (42).
    """

    noise: NoiseLaw = field(default_factory=Hyperbolic)
    omega: float = 1e6
    max_passes: int = 10
    covariance_path: bool = False
    precision: Literal["double", "single"] = "double"
    dynamics: Dynamics = field(default_factory=Constant)
    forgetting: float = 1.0

    def __post_init__(self) -> None:
        positive_number("omega", self.omega)
        require_scalar_law(self.noise)
        if self.max_passes < 1:
            raise InvalidInputError(f"max_passes is {self.max_passes}; at least one is needed.")
        if not 0.0 < self.forgetting <= 1.0:
            raise InvalidInputError(f"forgetting is {self.forgetting}; it must lie in (0, 1].")
        if self.precision not in ("double", "single"):
            raise InvalidInputError(f"precision is {self.precision!r}; 'double' or 'single'.")

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Run through the rows in order of time (in row order where there is none).

        The prior is the start of the recursion. `path` follows the order in which rows were
        taken, `info["order"]`; `info["rejected"]` counts rows of weight zero, `info["passes"]`
        the linearisations.
        """
        if prior is not None:
            prior.check(problem.names)
        start = self._start(problem, prior)
        theta = start[0]
        linear = problem.linearise(theta)
        if prior is None:
            linear.observability().require()
        for passes in range(1, self.max_passes + 1):
            result = self._run(linear, start, problem.scale, passes)
            assert result.sd is not None
            settled = bool(np.all(np.abs(result.theta - theta) < 0.01 * result.sd))
            theta = result.theta
            if problem.linear or settled:
                return result
            linear = problem.linearise(theta)
        return replace(result, converged=False)

    def _run(
        self,
        linear: LinearProblem,
        start: tuple[FloatArray, FloatArray],
        unit: FloatArray,
        passes: int,
    ) -> Estimate:
        dtype = np.float64 if self.precision == "double" else np.float32
        n, width, p = linear.B.shape
        white = linear.whitened()
        order = np.arange(n) if linear.time is None else np.argsort(linear.time, kind="stable")
        # the recursion runs in units in which the unknowns are of order one
        rows = Rows(
            np.ascontiguousarray(white.v[order], dtype=dtype),
            np.ascontiguousarray(white.A[order] * unit, dtype=dtype),
            white.size[order],
        )
        theta, root = start
        state = State((theta / unit).astype(dtype), (root / unit[:, None]).astype(dtype))
        weights, path = np.zeros((n, width), dtype=dtype), np.empty((n, p), dtype=dtype)
        kept = np.empty((n if self.covariance_path else 0, p, p), dtype=dtype)
        law, drift = self.noise, self._drift(linear, order, unit, dtype)
        written = Written(weights, path, kept)
        recurse(rows, law.compiled_weight, law.numbers, law.componentwise, drift, state, written)
        own, scale = in_rows(weights, order), np.outer(unit, unit)
        info: dict[str, Any] = {"order": order, "passes": passes}
        if self.covariance_path:
            info["covariance_path"] = kept * scale
        info["rejected"] = self._count_rejected(own)
        return Estimate(
            theta=state.theta * unit,
            covariance=(state.S @ state.S.T) * scale,
            weights=own if self.noise.componentwise else own[:, 0],
            path=path * unit,
            converged=True,
            info=info,
            names=linear.names,
            units=linear.units,
        )

    def _count_rejected(self, weights: FloatArray) -> int:
        """Rows (n, M) of weight zero.

        Raises
        ------
        UnobservableError
            All of them.
        """
        rejected = int((weights.max(axis=1) == 0.0).sum())
        if rejected == len(weights):
            raise UnobservableError(
                f"{self.noise!r} rejected all {rejected} rows from this start, so nothing was "
                "learnt. Start nearer (prior=...), or take a law that does not reject."
            )
        return rejected

    def _drift(self, linear: LinearProblem, order: IntArray, unit: FloatArray, dtype: Any) -> Drift:
        """The steps between rows of different times, in scaled units."""
        n, p = len(order), len(unit)
        at = np.full(n, -1)
        if isinstance(self.dynamics, Constant) and self.forgetting == 1.0:
            empty = np.zeros((0, p, p), dtype=dtype)
            return Drift(at, empty, empty, dtype(1.0))
        if linear.time is None:
            raise InvalidInputError("unknowns that drift need the times of the rows.")
        gaps = np.diff(linear.time[order])
        intervals, which = np.unique(gaps[gaps > 0.0], return_inverse=True)
        at[1:][gaps > 0.0] = which
        steps = [self.dynamics.step(p, float(interval)) for interval in intervals]
        F = np.array([F for F, _ in steps]).reshape(-1, p, p) * (unit / unit[:, None])
        Q = [Q / np.outer(unit, unit) for _, Q in steps]
        roots = np.array([semidefinite_root(np.ascontiguousarray(q)) for q in Q]).reshape(-1, p, p)
        grow = dtype(1.0 / np.sqrt(self.forgetting))
        return Drift(at, F.astype(dtype), roots.astype(dtype), grow)

    def _start(
        self, problem: Problem, prior: GaussianPrior | None
    ) -> tuple[FloatArray, FloatArray]:
        if prior is not None:
            return prior.mean, np.linalg.cholesky(prior.covariance)
        return problem.start, np.sqrt(self.omega) * np.diag(problem.scale)


def after_each_time(estimate: Estimate, linear: LinearProblem) -> tuple[FloatArray, FloatArray]:
    """Estimates (T, p) and covariances (T, p, p) when all rows of each time have been taken.

    Parameters
    ----------
    estimate : Estimate
        Of `Recursive(covariance_path=True)`.
    linear : LinearProblem
        The problem it was run on, with times.
    """
    assert linear.time is not None
    assert estimate.path is not None
    time = linear.time[estimate.info["order"]]
    last = np.flatnonzero(np.append(np.diff(time) > 0.0, True))
    return estimate.path[last], estimate.info["covariance_path"][last]


def innovation_covariances(
    estimate: Estimate, linear: LinearProblem, omega: float, rows: slice = slice(None)
) -> tuple[FloatArray, FloatArray]:
    """B P B' before each row (k, m, m), and the equivalent noise R^.5 diag(1 / w) R^.5.

    Parameters
    ----------
    estimate : Estimate
        Of `Recursive(covariance_path=True)` without a prior, rows in time order.
    linear : LinearProblem
        The problem it was run on.
    omega : float
        Its start.
    rows : slice
        The rows wanted.
    """
    first = omega * np.diag(linear.scale**2)
    P = np.concatenate([first[None], estimate.info["covariance_path"][:-1]])[rows]
    weights = estimate.weights if estimate.weights.ndim == 2 else estimate.weights[:, None]
    B, R = linear.B[rows], linear.R[rows]
    values, vectors = np.linalg.eigh(R)
    root = (vectors * np.sqrt(values)[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    noise = (root / weights[rows, None, :]) @ np.swapaxes(root, 1, 2)
    return B @ P @ np.swapaxes(B, 1, 2), noise
