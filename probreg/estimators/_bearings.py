"""What the estimators that take bearings only share."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError, UnobservableError
from probreg.problems.bearings import BearingProblem
from probreg.problems.linear import Problem
from probreg.typing import IntArray


def require_bearings(problem: Problem, name: str) -> BearingProblem:
    """Return the problem if it is one of bearings."""
    if not isinstance(problem, BearingProblem):
        raise InvalidInputError(
            f"{name} takes a BearingProblem, not a {type(problem).__name__}; for others there are "
            "Recursive, Irls and LeastSquares."
        )
    return problem


def in_time(problem: BearingProblem) -> tuple[BearingProblem, IntArray]:
    """The problem with its bearings in order of time, and that order."""
    if problem.time is None or bool(np.all(np.diff(problem.time) >= 0.0)):
        return problem, np.arange(len(problem))
    order = np.argsort(problem.time, kind="stable")
    return problem.part(order), order


def take_first(problem: BearingProblem, count: int, setting: str) -> BearingProblem:
    """The first bearings, whose lines of sight must meet by themselves."""
    few = problem.part(slice(count))
    if not few.lines_meet:
        problem.observability().require()
        raise UnobservableError(
            f"the first {len(few)} bearings do not determine where to start: their lines of sight "
            f"are parallel within their noise. Raise {setting} or pass a prior."
        )
    return few
