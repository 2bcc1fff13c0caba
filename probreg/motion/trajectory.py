"""Unknowns that move: a linear-Gaussian state space over scans, and its exact answers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.dynamics import semidefinite
from probreg.motion.state_space import (
    Backward,
    Filtered,
    Smoothed,
    in_order,
    reported,
    scale_matrices,
    steps,
)
from probreg.noise import NoiseLaw
from probreg.numerics import kalman
from probreg.numerics.linalg import inverse_roots
from probreg.prior import GaussianPrior
from probreg.typing import FloatArray
from probreg.validation import finite_array


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Scans y_t = H_t x_t + noise of a state that moves, x_(t+1) = F_t x_t + N(0, Q_t).

    Parameters
    ----------
    y : ndarray, shape (T, m)
        Reports or contrasts of each scan.
    H : ndarray, shape (T, m, d)
        Sensitivity to the state.
    R : ndarray, shape (T, m, m) or (T, k, m / k, m / k)
        Scale matrix of the noise, whole or its blocks along the diagonal: with many rows a scan
        only the blocks fit into memory.
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
        T, m = np.shape(self.y) if np.ndim(self.y) == 2 else (0, 0)
        if T == 0 or m == 0:
            raise InvalidInputError(
                f"y has shape {np.shape(self.y)}; (scans, components) is needed."
            )
        present = reported(self.present, T, m)
        # what was not reported does not count, whatever stands there
        y = finite_array("y", np.where(present, self.y, 0.0), (T, m))
        if np.shape(self.H)[:2] != (T, m) or np.ndim(self.H) != 3:
            raise InvalidInputError(
                f"H has shape {np.shape(self.H)}; ({T}, {m}, states) is needed."
            )
        H = finite_array("H", np.where(present[..., None], self.H, 0.0), (T, m, None))
        d = H.shape[2]
        R = scale_matrices(self.R, present)
        width = self.width or (R.shape[2] if R.ndim == 4 else m)
        if width < 1 or m % width:
            raise InvalidInputError(f"{m} components a scan are no whole rows of {width}.")
        F, Q = (steps(name, value, T, d) for name, value in (("F", self.F), ("Q", self.Q)))
        for k in range(T - 1):
            if k == 0 or (Q[k] != Q[k - 1]).any():
                semidefinite(f"Q[{k}]", Q[k])
        names = tuple(self.names or (f"state[{k}]" for k in range(d)))
        units = tuple(self.units or ("",) * d)
        if len(names) != d or len(units) != d:
            raise InvalidInputError(f"{d} states need {d} names and units; got {names}, {units}.")
        if not isinstance(self.prior, GaussianPrior):
            raise InvalidInputError("a trajectory needs a GaussianPrior of its first state.")
        self.prior.check(names)
        if self.time is not None:
            object.__setattr__(self, "time", in_order(self.time, T))
        fields = {"y": y, "H": H, "R": R, "F": F, "Q": Q, "present": present.astype(float)}
        for name, value in fields.items():
            object.__setattr__(self, name, value)
        for name, text in (("names", names), ("units", units), ("width", width)):
            object.__setattr__(self, name, text)

    def __len__(self) -> int:
        return len(self.y)

    def simulate(self, noise: NoiseLaw, rng: np.random.Generator) -> tuple[FloatArray, Trajectory]:
        """Draw a path (T, d) from prior and steps, and its rows from the law: a new trajectory."""
        T, d = len(self), len(self.names)
        path = np.empty((T, d))
        path[0] = self.prior.sample(rng)
        for t in range(1, T):
            root = kalman.semidefinite_root(np.ascontiguousarray(self.Q[t - 1]))
            path[t] = self.F[t - 1] @ path[t - 1] + root @ rng.standard_normal(d)
        v = noise.sample(rng, self.y.size // self.width, self.width).reshape(self.y.shape)
        values, vectors = np.linalg.eigh(self.blocks)
        grouped = v.reshape(values.shape)
        spread = np.einsum("tkij,tkj,tklj,tkl->tki", vectors, np.sqrt(values), vectors, grouped)
        y = np.einsum("tmd,td->tm", self.H, path) + spread.reshape(v.shape)
        return path, replace(self, y=y)

    @property
    def blocks(self) -> FloatArray:
        """R as blocks along its diagonal, shape (T, k, m / k, m / k)."""
        return self.R if self.R.ndim == 4 else self.R[:, None]

    def prior_path(self) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviations (T, d) before any report."""
        T, d = len(self), len(self.names)
        mean, sd = np.empty((T, d)), np.empty((T, d))
        x, P = self.prior.mean, self.prior.covariance
        for t in range(T):
            if t:
                x, P = self.F[t - 1] @ x, self.F[t - 1] @ P @ self.F[t - 1].T + self.Q[t - 1]
            mean[t], sd[t] = x, np.sqrt(np.diag(P))
        return mean, sd

    @cached_property
    def whitened(self) -> tuple[FloatArray, FloatArray, float]:
        """V (T, m), A (T, m, d) and the sum of log |R|."""
        T, k, width = self.blocks.shape[:3]
        flat = np.ascontiguousarray(self.blocks.reshape(-1, width, width))
        root, log_det = inverse_roots(flat)
        v = np.einsum("nij,nj->ni", root, self.y.reshape(-1, width))
        A = root @ self.H.reshape(len(root), width, -1)
        return v.reshape(T, -1), A.reshape(T, k * width, -1), float(log_det.sum())

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
        assert self.present is not None
        used = self.present
        if weights is not None:
            used = self.present * finite_array("weights", weights, self.y.shape)
            if (used < 0.0).any():
                raise InvalidInputError("a weight is negative.")
        Q = self.Q if step_scale is None else self.Q * np.outer(step_scale, step_scale)
        means, covariances, log_likelihood = kalman.run_filter(
            v,
            A,
            np.ascontiguousarray(used),
            np.ascontiguousarray(self.F),
            np.ascontiguousarray(Q),
            self.prior.mean,
            self.prior.covariance,
        )
        if not np.isfinite(log_likelihood):
            raise InvalidInputError(
                "the prior (or the process noise) is more than 300 000 times wider than a report "
                "is accurate, and double precision cannot hold both. Give a narrower prior."
            )
        value = float(log_likelihood) - 0.5 * log_det
        return Filtered(means[0], covariances[0], means[1], covariances[1], value)

    def smooth(self, filtered: Filtered | None = None) -> Smoothed:
        """Rauch-Tung-Striebel smoother."""
        known = self.filter() if filtered is None else filtered
        mean, covariance = np.empty_like(known.mean), np.empty_like(known.covariance)
        cross = np.empty_like(self.F)
        kalman.run_smoother(np.ascontiguousarray(self.F), *known[:4], mean, covariance, cross)
        return Smoothed(mean, covariance, cross)

    def backward(self, filtered: Filtered) -> Backward:
        """The map from standard normal numbers to paths given all scans."""
        F = np.ascontiguousarray(self.F)
        gains, roots = np.empty_like(F), np.empty_like(filtered.covariance)
        kalman.backward_map(F, filtered.predicted_covariance, filtered.covariance, gains, roots)
        mean = np.empty_like(filtered.mean)
        kalman.smoothed_mean(gains, filtered.predicted, filtered.mean, mean)
        return Backward(mean, gains, roots)

    def draw(
        self, rng: np.random.Generator, num_draws: int, filtered: Filtered | None = None
    ) -> FloatArray:
        """Simulation smoother: independent paths (num_draws, T, d) given all scans."""
        back = self.backward(self.filter() if filtered is None else filtered)
        return back.paths(rng.standard_normal((num_draws, *back.mean.shape)))
