"""How the unknowns move between scans."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import block_diag

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_number


class Dynamics(Protocol):
    """A linear-Gaussian step: b(t + dt) = F b(t) + N(0, Q)."""

    def step(self, dim: int, interval: float) -> tuple[FloatArray, FloatArray]:
        """F and Q, both (d, d), of a step of `interval` seconds."""


@dataclass(frozen=True)
class Constant:
    """The unknowns do not move."""

    def step(self, dim: int, interval: float) -> tuple[FloatArray, FloatArray]:
        """Identity and zero."""
        return np.eye(dim), np.zeros((dim, dim))


@dataclass(frozen=True, eq=False)
class RandomWalk:
    """The unknowns drift: Q grows in proportion to time.

    Parameters
    ----------
    rate : ndarray, shape (d,) or (d, d)
        Variance (or covariance) gained in a second, units squared a second.

    Raises
    ------
    InvalidInputError
        Not positive semi-definite, or negative variances.
    """

    rate: FloatArray

    def __post_init__(self) -> None:
        rate = np.atleast_1d(np.asarray(self.rate, dtype=float))
        shape = (None,) if rate.ndim == 1 else (rate.shape[0], rate.shape[0])
        rate = finite_array("rate of RandomWalk", rate, shape)
        if rate.ndim == 1:
            rate = np.diag(rate)
        object.__setattr__(self, "rate", semidefinite("rate of RandomWalk", rate))

    def step(self, dim: int, interval: float) -> tuple[FloatArray, FloatArray]:
        """Identity and rate times the interval."""
        _require_dim(self, self.rate, dim)
        positive_number("interval", interval, zero=True)
        return np.eye(dim), interval * self.rate


@dataclass(frozen=True, eq=False)
class LinearGaussian:
    """A given step: F and Q a scan of `interval` seconds.

    A gap of k scans is k steps; other intervals are refused.

    Parameters
    ----------
    transition : ndarray, shape (d, d)
        F.
    noise : ndarray, shape (d, d)
        Q.
    interval : float
        Seconds of one step.

    Raises
    ------
    InvalidInputError
        Q not positive semi-definite, shapes that do not fit, an interval not above zero.
    """

    transition: FloatArray
    noise: FloatArray
    interval: float = 1.0

    def __post_init__(self) -> None:
        transition = finite_array("transition", self.transition, (None, None))
        d = len(transition)
        object.__setattr__(self, "transition", finite_array("transition", transition, (d, d)))
        noise = finite_array("noise of LinearGaussian", self.noise, (d, d))
        object.__setattr__(self, "noise", semidefinite("noise of LinearGaussian", noise))
        positive_number("interval", self.interval)

    def step(self, dim: int, interval: float) -> tuple[FloatArray, FloatArray]:
        """F^k and the Q gathered over k scans."""
        _require_dim(self, self.transition, dim)
        positive_number("interval", interval, zero=True)
        scans = interval / self.interval
        if abs(scans - round(scans)) > 1e-6 * max(scans, 1.0):
            raise InvalidInputError(
                f"an interval of {interval:g} s is no whole number of steps of {self.interval:g} "
                "s; LinearGaussian cannot be cut. Take RandomWalk."
            )
        F, Q = np.eye(dim), np.zeros((dim, dim))
        for _ in range(round(scans)):
            F, Q = self.transition @ F, self.transition @ Q @ self.transition.T + self.noise
        return F, Q


@dataclass(frozen=True)
class NearConstantVelocity:
    """Position and velocity along k axes, states (positions, velocities).

    The acceleration is white from scan to scan and constant within a step.

    Parameters
    ----------
    acceleration_sd : float
        Standard deviation of the acceleration of one step, m/s^2.

    Raises
    ------
    InvalidInputError
        It is not above zero.
    """

    acceleration_sd: float

    def __post_init__(self) -> None:
        positive_number("acceleration_sd", self.acceleration_sd)

    def step(self, dim: int, interval: float) -> tuple[FloatArray, FloatArray]:
        """F and Q of one step; Q has rank k, for one acceleration moves both."""
        if dim % 2:
            raise InvalidInputError(f"{dim} states are no pairs of position and velocity.")
        eye = np.eye(dim // 2)
        reach = np.array([0.5 * interval**2, interval])
        F = np.kron(np.array([[1.0, interval], [0.0, 1.0]]), eye)
        return F, self.acceleration_sd**2 * np.kron(np.outer(reach, reach), eye)


@dataclass(frozen=True, eq=False)
class Together:
    """Independent groups of states, one after the other, each with dynamics of its own.

    Parameters
    ----------
    parts : tuple of (Dynamics, int)
        Dynamics and number of states of each group.
    """

    parts: tuple[tuple[Dynamics, int], ...]

    def step(self, dim: int, interval: float) -> tuple[FloatArray, FloatArray]:
        """Block-diagonal F and Q.

        Raises
        ------
        InvalidInputError
            The groups do not add up to `dim` states.
        """
        if sum(count for _, count in self.parts) != dim:
            raise InvalidInputError(
                f"groups of {[count for _, count in self.parts]} states; the problem has {dim}."
            )
        steps = [dynamics.step(count, interval) for dynamics, count in self.parts]
        return block_diag(*(F for F, _ in steps)), block_diag(*(Q for _, Q in steps))


def semidefinite(name: str, matrix: FloatArray) -> FloatArray:
    """Check that a matrix is symmetric and positive semi-definite.

    Raises
    ------
    InvalidInputError
        It is not; gives its smallest eigenvalue.
    """
    size = float(np.abs(matrix).max(initial=0.0))
    if np.abs(matrix - matrix.T).max(initial=0.0) > 1e-8 * size:
        raise InvalidInputError(f"{name} is not symmetric; pass a covariance matrix.")
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < -1e-9 * size:
        raise InvalidInputError(
            f"{name} is not positive semi-definite (smallest eigenvalue {least:.3g}): no noise "
            "has this covariance."
        )
    return matrix


def _require_dim(dynamics: object, matrix: FloatArray, dim: int) -> None:
    if len(matrix) != dim:
        raise InvalidInputError(
            f"{type(dynamics).__name__} moves {len(matrix)} unknowns; the problem has {dim}."
        )
