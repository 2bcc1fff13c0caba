"""What an estimator returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from probreg.prior import GaussianPrior
from probreg.problems.linear import Problem
from probreg.typing import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Estimate:
    """A point estimate with what is known about it.

    Attributes
    ----------
    theta : ndarray, shape (p,)
        The estimate, in the problem's units.
    covariance : ndarray, shape (p, p), or None
        What the estimator claims about its error.
    weights : ndarray, shape (n,) or (n, M)
        Weight each row (or component) had.
    path : ndarray, shape (n, p), or None
        The estimate after each row, for recursive methods.
    converged : bool
    info : mapping
        Diagnostics of the method, described in its docstring.
    names, units : tuple of str
    """

    theta: FloatArray
    covariance: FloatArray | None
    weights: FloatArray
    path: FloatArray | None
    converged: bool
    info: Mapping[str, Any] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()

    @property
    def sd(self) -> FloatArray | None:
        """Claimed standard deviations, shape (p,)."""
        return None if self.covariance is None else np.sqrt(np.diag(self.covariance))

    def __str__(self) -> str:
        """A table with angles in milliradians."""
        sd = np.full(self.theta.size, np.nan) if self.sd is None else self.sd
        lines = []
        for name, unit, value, spread in zip(self.names, self.units, self.theta, sd, strict=True):
            factor, shown = (1e3, "mrad") if unit == "rad" else (1.0, unit)
            lines.append(f"{name:<20} {factor * value:12.4f} +- {factor * spread:<10.4f} {shown}")
        return "\n".join(lines) + ("" if self.converged else "\nnot converged")


class Estimator(Protocol):
    """What a study or a conformance test asks of an estimator: settings and one method.

    Two class attributes say what a method does not take: `problem_type`, the one kind of
    problem that it is for, and `takes_prior = False`.
    """

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Estimate the unknowns of a problem.

        This is the contract of every estimator; the docstring of a method says what differs
        and what its `info` holds.

        Parameters
        ----------
        problem : Problem
            Linear, or nonlinear and then linearised anew as the estimate moves.
        prior : GaussianPrior, optional
            On the unknowns; flat by default. Refused by methods that have no place for one.
        rng : numpy.random.Generator, optional
            Draws what a method draws at random and is passed on to its start; deterministic
            methods do not use it. The same generator gives the same estimate.

        Returns
        -------
        Estimate
            With the problem's names and units.

        Raises
        ------
        UnobservableError
            Combinations of unknowns that neither data nor prior determine, by name; or so many
            rows rejected that those left determine nothing.
        InvalidInputError
            A problem of another kind, a prior that does not fit or is refused, too few rows, no
            generator where one is needed.
        """


def in_rows(values: FloatArray, order: IntArray) -> FloatArray:
    """Numbers found in some order (n, ...), put back into the order of the rows."""
    own = np.empty_like(values)
    own[order] = values
    return own
