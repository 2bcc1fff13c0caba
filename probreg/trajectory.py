"""Unknowns that move: a linear-Gaussian state space over scans, and its exact answers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from probreg import _kalman
from probreg._linalg import inverse_roots
from probreg.dynamics import Dynamics, semidefinite
from probreg.errors import InvalidInputError
from probreg.noise import NoiseLaw
from probreg.prior import GaussianPrior
from probreg.problem import RegistrationProblem
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_definite


class Filtered(NamedTuple):
    """What a Kalman filter knows before and after each scan.

    Attributes
    ----------
    predicted, mean : ndarray, shape (T, d)
    predicted_covariance, covariance : ndarray, shape (T, d, d)
    log_likelihood : float
        Log marginal likelihood of all rows.
    """

    predicted: FloatArray
    predicted_covariance: FloatArray
    mean: FloatArray
    covariance: FloatArray
    log_likelihood: float


class Smoothed(NamedTuple):
    """What all scans together say about each.

    Attributes
    ----------
    mean : ndarray, shape (T, d)
    covariance : ndarray, shape (T, d, d)
    cross : ndarray, shape (T - 1, d, d)
        Covariance of scan t with scan t + 1.
    """

    mean: FloatArray
    covariance: FloatArray
    cross: FloatArray


class Backward(NamedTuple):
    """A Gaussian posterior of a path as an affine map of standard normal numbers.

    Attributes
    ----------
    mean : ndarray, shape (T, d)
    gains : ndarray, shape (T - 1, d, d)
    roots : ndarray, shape (T, d, d)
    """

    mean: FloatArray
    gains: FloatArray
    roots: FloatArray

    def paths(self, z: FloatArray) -> FloatArray:
        """Paths (k, T, d) of standard normal numbers (k, T, d)."""
        delta = np.empty_like(z)
        _kalman.spread(self.gains, self.roots, z, delta)
        return self.mean + delta

    def pull_back(self, slope: FloatArray) -> FloatArray:
        """Derivatives by z (k, T, d) from derivatives by paths (k, T, d)."""
        out = np.empty_like(slope)
        _kalman.gather(self.gains, self.roots, np.ascontiguousarray(slope), out)
        return out


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Scans y_t = H_t x_t + noise of a state that moves, x_(t+1) = F_t x_t + N(0, Q_t).

    Parameters
    ----------
    y : ndarray, shape (T, m)
        Reports or contrasts of each scan.
    H : ndarray, shape (T, m, d)
        Sensitivity to the state.
    R : ndarray, shape (T, m, m)
        Scale matrix of the noise.
    F, Q : ndarray, shape (T - 1, d, d)
        Step from each scan to the next.
    prior : GaussianPrior
        Of the state at the first scan.
    time : ndarray, shape (T,), optional
        Seconds.
    names, units : tuple of str
        Of the d states.
    present : ndarray of bool, shape (T, m), optional
        Components that were reported; by default all. What y, H and R hold for the others does
        not count.
    width : int, optional
        Components of a row, on which a noise law acts as a whole; by default all m of a scan.

    Raises
    ------
    InvalidInputError
        Mismatched shapes, NaN, R not positive definite, Q not positive semi-definite.
    """

    y: FloatArray
    H: FloatArray
    R: FloatArray
    F: FloatArray
    Q: FloatArray
    prior: GaussianPrior
    time: FloatArray | None = None
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    present: FloatArray | None = None
    width: int = 0

    def __post_init__(self) -> None:
        y = finite_array("y", self.y, (None, None))
        T, m = y.shape
        if T == 0 or m == 0:
            raise InvalidInputError("there is no scan.")
        H = finite_array("H", self.H, (T, m, None))
        d = H.shape[2]
        R = positive_definite("R", finite_array("R", self.R, (T, m, m)))
        F, Q = (_steps(name, value, T, d) for name, value in (("F", self.F), ("Q", self.Q)))
        for k in range(T - 1):
            if k == 0 or (Q[k] != Q[k - 1]).any():
                semidefinite(f"Q[{k}]", Q[k])
        names = tuple(self.names or (f"state[{k}]" for k in range(d)))
        if len(names) != d:
            raise InvalidInputError(f"{d} states need {d} names; got {names}.")
        if not isinstance(self.prior, GaussianPrior):
            raise InvalidInputError("a trajectory needs a GaussianPrior of its first state.")
        self.prior.check(names)
        present = np.ones((T, m)) if self.present is None else np.asarray(self.present)
        if present.shape != (T, m):
            raise InvalidInputError(f"present has shape {present.shape}; ({T}, {m}) is needed.")
        present = present.astype(bool).astype(float)
        y, H, R = y * present, H * present[..., None], _marginal(R, present)
        if self.time is not None:
            time = finite_array("time", self.time, (T,))
            late = np.flatnonzero(np.diff(time) < 0.0)
            if late.size:
                raise InvalidInputError(
                    f"time goes back after scan {late[0]} ({time[late[0]]:g} to "
                    f"{time[late[0] + 1]:g} s); sort the scans first."
                )
        width = self.width or m
        if m % width:
            raise InvalidInputError(f"{m} components a scan are no whole rows of {width}.")
        fields = {"y": y, "H": H, "R": R, "F": F, "Q": Q, "names": names, "present": present}
        object.__setattr__(self, "width", width)
        for name, value in fields.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "units", tuple(self.units or ("",) * d))

    @classmethod
    def drifting(
        cls, problem: RegistrationProblem, dynamics: Dynamics, prior: GaussianPrior
    ) -> Trajectory:
        """The unknowns of a linear problem, moving between the times of its rows.

        Rows of one time are one scan. Gaps in time are longer steps.

        Raises
        ------
        InvalidInputError
            The problem has no times.
        """
        if not isinstance(problem, RegistrationProblem):
            raise InvalidInputError(
                f"takes a linear RegistrationProblem, not a {type(problem).__name__}: linearise it."
            )
        if problem.time is None:
            raise InvalidInputError("a bias that drifts needs the times of the rows.")
        assert problem.size is not None
        times, scan = np.unique(problem.time, return_inverse=True)
        counts = np.bincount(scan)
        order = np.argsort(scan, kind="stable")
        place = np.arange(len(order)) - np.repeat(np.cumsum(counts) - counts, counts)
        _, width, p = problem.B.shape
        T, most = len(times), int(counts.max())
        m = most * width
        y, H = np.zeros((T, m)), np.zeros((T, m, p))
        R, present = np.tile(np.eye(m), (T, 1, 1)), np.zeros((T, m))
        for row, k in zip(order, place, strict=True):
            t, own = scan[row], slice(k * width, (k + 1) * width)
            y[t, own], H[t, own], R[t, own, own] = problem.y[row], problem.B[row], problem.R[row]
            present[t, own] = np.arange(width) < problem.size[row]
        steps = [dynamics.step(p, float(dt)) for dt in np.diff(times)]
        F = np.array([step[0] for step in steps]).reshape(T - 1, p, p)
        Q = np.array([step[1] for step in steps]).reshape(T - 1, p, p)
        return cls(y, H, R, F, Q, prior, times, problem.names, problem.units, present, width)

    def __len__(self) -> int:
        return len(self.y)

    def simulate(self, noise: NoiseLaw, rng: np.random.Generator) -> tuple[FloatArray, Trajectory]:
        """Draw a path (T, d) from prior and steps, and its rows from the law: a new trajectory."""
        T, d = len(self), len(self.names)
        path = np.empty((T, d))
        path[0] = self.prior.sample(rng)
        for t in range(1, T):
            root = _kalman.semidefinite_root(np.ascontiguousarray(self.Q[t - 1]))
            path[t] = self.F[t - 1] @ path[t - 1] + root @ rng.standard_normal(d)
        v = noise.sample(rng, self.y.size // self.width, self.width).reshape(self.y.shape)
        values, vectors = np.linalg.eigh(self.R)
        spread = np.einsum("tij,tj,tkj,tk->ti", vectors, np.sqrt(values), vectors, v)
        y = np.einsum("tmd,td->tm", self.H, path) + spread
        return path, replace(self, y=y)

    def rows(self) -> RegistrationProblem:
        """The rows as a linear problem, for recursive estimators that know the dynamics.

        Rows of a scan must not be correlated with each other; absent components carry nothing.

        Raises
        ------
        InvalidInputError
            Rows that are correlated, or no times.
        """
        T, m = self.y.shape
        k = m // self.width
        if self.time is None:
            raise InvalidInputError("rows of a trajectory need the times of its scans.")
        blocks = self.R.reshape(T, k, self.width, k, self.width)
        own = np.einsum("tijil->tijl", blocks)
        if np.count_nonzero(blocks) > np.count_nonzero(own):
            raise InvalidInputError("rows of one scan are correlated; make them one row (width).")
        assert self.present is not None
        seen = self.present.reshape(T * k, self.width).any(axis=1)
        return RegistrationProblem(
            self.y.reshape(T * k, self.width)[seen],
            self.H.reshape(T * k, self.width, -1)[seen],
            own.reshape(T * k, self.width, self.width)[seen],
            np.repeat(self.time, k)[seen],
            self.names,
            self.units,
        )

    @cached_property
    def whitened(self) -> tuple[FloatArray, FloatArray, float]:
        """V (T, m), A (T, m, d) and the sum of log |R|."""
        root, log_det = inverse_roots(np.ascontiguousarray(self.R))
        v = np.einsum("tij,tj->ti", root, self.y)
        return v, np.ascontiguousarray(root @ self.H), float(log_det.sum())

    @cached_property
    def filtered(self) -> Filtered:
        """The Kalman filter under Gaussian noise, kept after the first call."""
        return self.filter()

    def filter(
        self, weights: FloatArray | None = None, step_scale: FloatArray | None = None
    ) -> Filtered:
        """Kalman filter.

        Parameters
        ----------
        weights : ndarray, shape (T, m), optional
            Divide the variance of each whitened component.
        step_scale : ndarray, shape (d,), optional
            Multiply the standard deviation of each state's process noise.
        """
        v, A, log_det = self.whitened
        T, d = len(self), A.shape[2]
        assert self.present is not None
        used = self.present if weights is None else self.present * weights
        Q = self.Q if step_scale is None else self.Q * np.outer(step_scale, step_scale)
        means, covariances = np.empty((2, T, d)), np.empty((2, T, d, d))
        log_likelihood = _kalman.run_filter(
            v,
            A,
            np.ascontiguousarray(used),
            np.ascontiguousarray(self.F),
            np.ascontiguousarray(Q),
            self.prior.mean,
            self.prior.covariance,
            means[0],
            covariances[0],
            means[1],
            covariances[1],
        )
        value = float(log_likelihood) - 0.5 * log_det
        return Filtered(means[0], covariances[0], means[1], covariances[1], value)

    def smooth(self, filtered: Filtered | None = None) -> Smoothed:
        """Rauch-Tung-Striebel smoother."""
        known = self.filter() if filtered is None else filtered
        mean, covariance = np.empty_like(known.mean), np.empty_like(known.covariance)
        cross = np.empty_like(self.F)
        _kalman.run_smoother(np.ascontiguousarray(self.F), *known[:4], mean, covariance, cross)
        return Smoothed(mean, covariance, cross)

    def backward(self, filtered: Filtered) -> Backward:
        """The map from standard normal numbers to paths given all scans."""
        F = np.ascontiguousarray(self.F)
        gains, roots = np.empty_like(F), np.empty_like(filtered.covariance)
        _kalman.backward_map(F, filtered.predicted_covariance, filtered.covariance, gains, roots)
        mean = np.empty_like(filtered.mean)
        _kalman.smoothed_mean(gains, filtered.predicted, filtered.mean, mean)
        return Backward(mean, gains, roots)

    def draw(
        self, rng: np.random.Generator, num_draws: int, filtered: Filtered | None = None
    ) -> FloatArray:
        """Simulation smoother: independent paths (num_draws, T, d) given all scans."""
        back = self.backward(self.filter() if filtered is None else filtered)
        return back.paths(rng.standard_normal((num_draws, *back.mean.shape)))


def _steps(name: str, value: FloatArray, T: int, d: int) -> FloatArray:
    """Steps (T - 1, d, d), from one for all or one each."""
    try:
        full = np.broadcast_to(value, (T - 1, d, d))
    except ValueError:
        raise InvalidInputError(
            f"{name} has shape {np.shape(value)}; ({T - 1}, {d}, {d}) or ({d}, {d}) is needed."
        ) from None
    return finite_array(name, full, (T - 1, d, d))


def _marginal(R: FloatArray, present: FloatArray) -> FloatArray:
    """R of the components present; the others uncorrelated, of unit variance."""
    both = present[:, :, None] * present[:, None, :]
    marginal: FloatArray = R * both
    at = np.arange(R.shape[1])
    marginal[:, at, at] += 1.0 - present
    return marginal
