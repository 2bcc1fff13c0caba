"""Modes of a recording's problem, re-linearised until they rest."""

from __future__ import annotations

import numpy as np

from probreg.noise import NoiseLaw
from probreg.posterior import WeightedFit
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem
from probreg.problems.recording import RecordingProblem
from probreg.typing import FloatArray, IntArray

_PASSES = 12
_CLOSE = 0.02  # posterior standard deviations, of a pass
_STEP = 1e-3  # the same of a reweighting


def settle(
    problem: RecordingProblem,
    law: NoiseLaw,
    prior: GaussianPrior,
    theta: FloatArray,
    *,
    near: bool = False,
) -> tuple[FloatArray, LinearProblem]:
    """The mode, and the linear problem tangent within a fiftieth of a standard deviation of it.

    Unless theta is `near` the mode, the first pass takes a robust start.
    """
    for k in range(_PASSES):
        linear = problem.linearise(theta)
        fit = WeightedFit(linear, law, prior)
        mode = fit.mode(theta if near or k else None, tolerance=_STEP)
        step, theta = mode.theta - theta, mode.theta
        precision = fit.normal_matrix(linear.whitened(), mode.weights)
        if float(step @ precision @ step) < _CLOSE**2:
            break
    return theta, linear


def some_rows(linear: LinearProblem, rows: IntArray) -> LinearProblem:
    """Some of the rows of a linear problem, no wider than they need."""
    assert linear.size is not None
    assert linear.time is not None
    size = linear.size[rows]
    m = int(size.max())
    return LinearProblem(
        linear.y[rows, :m],
        linear.B[rows, :m],
        linear.R[rows, :m, :m],
        linear.time[rows],
        linear.names,
        linear.units,
        size,
    )


def thinned(n: int, most: int) -> IntArray:
    """Numbers of at most so many rows out of n, evenly spread."""
    return np.unique(np.linspace(0, n - 1, min(n, most)).astype(np.int64))
