"""The targets of the per-scan tracker: what it takes over from the scans before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.trajectory import Trajectory
from probreg.samplers.scans._target import Memory, ScanPrior, ScanTarget, flat, gaussian, moments


@dataclass(frozen=True)
class Flat(ScanTarget):
    """Nothing: each scan by itself, the paper as it is meant.

    A warm start is an initial value and not a prior, so the error has a floor at that of one
    scan.
    """

    def prior(self, model: Trajectory, scan: int, memory: Memory) -> ScanPrior:
        """Flat."""
        return flat(len(model.names))


@dataclass(frozen=True)
class AsPrinted(Flat):
    """The paper's equation (21) as printed, to show that it fails.

    Its density grows with the residual and drives the bias into a corner of the box.
    """

    sign: ClassVar[float] = -1.0


@dataclass(frozen=True)
class GaussianMemory(ScanTarget):
    """A Gaussian fitted to the last scan's draws, moved on by the dynamics."""

    def prior(self, model: Trajectory, scan: int, memory: Memory) -> ScanPrior:
        """The trajectory's own prior at first, then mean and covariance of the draws moved on."""
        if memory.draws is None:
            return gaussian(model.prior.mean, model.prior.covariance)
        mean, covariance = moments(memory.draws)
        F, Q = model.F[scan - 1], model.Q[scan - 1]
        return gaussian(F @ mean, F @ covariance @ F.T + Q)


@dataclass(frozen=True)
class ParticleMemory(ScanTarget):
    """Draws of the last scan, each moved on by the dynamics: the chain chooses among them.

    Parameters
    ----------
    count : int
        Draws carried on, evenly spaced.
    """

    count: int = 400

    def __post_init__(self) -> None:
        if self.count < 2:
            raise InvalidInputError(f"count is {self.count}; at least two particles are needed.")

    def prior(self, model: Trajectory, scan: int, memory: Memory) -> ScanPrior:
        """The trajectory's own prior at first, then N(F x_j, Q) with j chosen by the chain.

        Raises
        ------
        InvalidInputError
            Q is singular: particles that do not spread cannot follow.
        """
        if memory.draws is None:
            return gaussian(model.prior.mean, model.prior.covariance)
        F, Q = model.F[scan - 1], model.Q[scan - 1]
        try:
            root = np.linalg.inv(np.linalg.cholesky(Q))
        except np.linalg.LinAlgError:
            raise InvalidInputError(
                "Q is singular, so particles do not spread and would soon be one. Take "
                "AccumulatedMemory for a constant bias, or GaussianMemory."
            ) from None
        at = np.linspace(0, len(memory.draws) - 1, min(self.count, len(memory.draws))).astype(int)
        return ScanPrior(memory.draws[at] @ F.T, root)


@dataclass(frozen=True)
class AccumulatedMemory(ScanTarget):
    """The likelihood of all scans so far, by its sufficient statistics: Gaussian noise only.

    For a constant bias, where moments refitted scan by scan lose their coverage.
    """

    gaussian_only: ClassVar[bool] = True

    def prior(self, model: Trajectory, scan: int, memory: Memory) -> ScanPrior:
        """What the Kalman filter knows before the scan."""
        if scan == 0:
            return gaussian(model.prior.mean, model.prior.covariance)
        known = model.filtered
        return gaussian(known.predicted[scan], known.predicted_covariance[scan])


@dataclass(frozen=True)
class AllScans(ScanTarget):
    """The rows of all scans so far, for a bias that is constant: exact under any noise law.

    No statistic holds what rows under such a law say, so a step costs as many rows as there
    have been.
    """

    def first(self, scan: int) -> int:
        """The first scan of all."""
        return 0

    def prior(self, model: Trajectory, scan: int, memory: Memory) -> ScanPrior:
        """The trajectory's own prior.

        Raises
        ------
        InvalidInputError
            The unknowns move.
        """
        moved = model.Q.any() or (np.eye(len(model.names)) != model.F).any()
        if moved:
            raise InvalidInputError(
                "AllScans takes the unknowns for constant; they drift here. Take GaussianMemory."
            )
        return gaussian(model.prior.mean, model.prior.covariance)
