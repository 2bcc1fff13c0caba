"""What a scan's chain believes before it sees the scan."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.trajectory import Trajectory
from probreg.typing import FloatArray


class ScanPrior(NamedTuple):
    """Gaussians of one covariance about equally likely centres; flat without a centre.

    Attributes
    ----------
    centres : ndarray, shape (k, d)
    root : ndarray, shape (d, d)
        Whitening root of the common covariance.
    """

    centres: FloatArray
    root: FloatArray


class Memory(NamedTuple):
    """What is carried from one scan to the next.

    Attributes
    ----------
    draws : ndarray, shape (n, d), or None
        Of the last scan after burn-in; None before the first.
    """

    draws: FloatArray | None


class ScanTarget(ABC):
    """How a tracker uses the past.

    Attributes
    ----------
    sign : float
        1, or -1 to turn the rows' density upside down.
    gaussian_only : bool
        Whether what is taken over is right under Gaussian noise only.
    """

    sign: ClassVar[float] = 1.0
    gaussian_only: ClassVar[bool] = False

    def first(self, scan: int) -> int:
        """The first scan whose rows the chain of `scan` looks at: by default its own."""
        return scan

    @abstractmethod
    def prior(self, model: Trajectory, scan: int, memory: Memory) -> ScanPrior:
        """What is believed before those rows."""


def require_scene(model: object, rng: object) -> None:
    """Raise unless there is a trajectory to follow and a generator to do it with."""
    if not isinstance(model, Trajectory):
        raise InvalidInputError(f"follows a Trajectory, not a {type(model).__name__}.")
    if not isinstance(rng, np.random.Generator):
        raise InvalidInputError("rng must be a numpy.random.Generator: default_rng(seed).")


def flat(d: int) -> ScanPrior:
    """No belief at all."""
    return ScanPrior(np.empty((0, d)), np.eye(d))


def gaussian(mean: FloatArray, covariance: FloatArray) -> ScanPrior:
    """One Gaussian."""
    root = np.linalg.inv(np.linalg.cholesky(covariance))
    return ScanPrior(np.atleast_2d(mean), root)


def moments(draws: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and covariance of draws (n, d)."""
    return draws.mean(axis=0), np.atleast_2d(np.cov(draws.T))
