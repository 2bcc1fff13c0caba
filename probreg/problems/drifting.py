"""Linear problems whose unknowns move: their rows as scans of a trajectory, and back."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.dynamics import Dynamics
from probreg.motion.trajectory import Trajectory
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem


def as_trajectory(problem: LinearProblem, dynamics: Dynamics, prior: GaussianPrior) -> Trajectory:
    """The unknowns of a linear problem, moving between the times of its rows.

    Rows of one time are one scan. Gaps in time are longer steps.

    Parameters
    ----------
    problem : LinearProblem
        With times.
    dynamics : Dynamics
    prior : GaussianPrior
        Of the unknowns at the first time.

    Raises
    ------
    InvalidInputError
        The problem has no times.
    """
    if not isinstance(problem, LinearProblem):
        raise InvalidInputError(
            f"takes a LinearProblem, not a {type(problem).__name__}: linearise it."
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
    spot = scan[order], place
    y, H = np.zeros((T, most, width)), np.zeros((T, most, width, p))
    R, present = np.tile(np.eye(width), (T, most, 1, 1)), np.zeros((T, most, width), dtype=bool)
    y[spot], H[spot], R[spot] = problem.y[order], problem.B[order], problem.R[order]
    present[spot] = np.arange(width) < problem.size[order, None]
    steps = [dynamics.step(p, float(dt)) for dt in np.diff(times)]
    return Trajectory(
        y=y.reshape(T, most * width),
        H=H.reshape(T, most * width, p),
        R=R,
        F=np.array([step[0] for step in steps]).reshape(T - 1, p, p),
        Q=np.array([step[1] for step in steps]).reshape(T - 1, p, p),
        prior=prior,
        time=times,
        names=problem.names,
        units=problem.units,
        present=present.reshape(T, most * width),
        width=width,
    )


def as_rows(trajectory: Trajectory) -> LinearProblem:
    """The rows of a trajectory as a linear problem, for recursive estimators that know its steps.

    Rows of a scan must not be correlated with each other; absent components carry nothing.

    Raises
    ------
    InvalidInputError
        Rows that are correlated, or no times.
    """
    T, m = trajectory.y.shape
    k, width = m // trajectory.width, trajectory.width
    if trajectory.time is None:
        raise InvalidInputError("rows of a trajectory need the times of its scans.")
    own = trajectory.blocks
    if own.shape[1] != k:
        full = trajectory.R.reshape(T, k, width, k, width)
        own = np.einsum("tijil->tijl", full)
        if np.count_nonzero(full) > np.count_nonzero(own):
            raise InvalidInputError("rows of one scan are correlated; make them one row (width).")
    assert trajectory.present is not None
    present = trajectory.present.reshape(-1, width)
    seen = present.any(axis=1)
    # reported components first, as padded rows want them
    first = np.argsort(-present[seen], axis=1, kind="stable")
    at = np.arange(len(first))[:, None]
    return LinearProblem(
        y=trajectory.y.reshape(-1, width)[seen][at, first],
        B=trajectory.H.reshape(len(present), width, -1)[seen][at, first],
        R=own.reshape(-1, width, width)[seen][at[:, None], first[:, :, None], first[:, None, :]],
        time=np.repeat(trajectory.time, k)[seen],
        names=trajectory.names,
        units=trajectory.units,
        size=present[seen].sum(axis=1).astype(int),
    )
