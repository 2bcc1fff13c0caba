"""Registration problems: rows from which the unknown target position has been eliminated.

A row is one target instant. Rows seen by different numbers of sensors have different
lengths; they are kept in one array, padded with components that carry no information
(y = 0, B = 0, unit R), and `size` tells how many components of a row are real.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from probreg.errors import InvalidInputError
from probreg.numerics.linalg import inverse_roots
from probreg.problems.observability import Observability, observability_of
from probreg.typing import FloatArray, IntArray
from probreg.validation import finite_array, positive_definite

_SCALES = {"m": 1.0, "rad": 1e-3, "s": 1e-2, "m/m": 1e-4}
_PRIOR_SD = {"m": 100.0, "rad": float(np.deg2rad(1.0)), "s": 0.5, "m/m": 1e-3}


class Problem(Protocol):
    """What estimators and posteriors ask of a problem, linear or not."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the unknowns."""

    @property
    def linear(self) -> bool:
        """Whether `linearise` gives the same rows everywhere."""

    @property
    def start(self) -> FloatArray:
        """Where it is linearised first, shape (p,)."""

    @property
    def scale(self) -> FloatArray:
        """Order of magnitude of the unknowns, shape (p,): the unit of a diffuse start."""

    @property
    def prior_sd(self) -> FloatArray:
        """Standard deviations of the default prior about `start`, shape (p,)."""

    @property
    def exact(self) -> WhitenedRows | None:
        """Whitened rows that are right at any theta; None where only linearised ones exist."""

    def residual(self, theta: FloatArray) -> FloatArray:
        """Residuals (n, M) at theta (p,)."""

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Derivative (n, M, p) of the residuals."""

    def linearise(self, theta: FloatArray) -> LinearProblem:
        """The linear problem that is tangent at theta."""

    def shifted(self, row: int, component: int, by: float) -> Problem:
        """The same problem with one component of one report moved."""


class WhitenedRows(Protocol):
    """Whitened rows, of which densities are made."""

    @property
    def size(self) -> IntArray:
        """Number of real components of each row, shape (n,)."""

    @property
    def log_det(self) -> FloatArray:
        """Log |R| of each row, shape (n,)."""

    def residual(self, theta: FloatArray) -> FloatArray:
        """Whitened residuals (..., n, M) at theta (..., p)."""

    def pull_back(self, theta: FloatArray, v: FloatArray) -> FloatArray:
        """Minus the transposed derivative of the residuals at theta on v (..., n, M): (..., p)."""

    def part(self, chosen: slice) -> WhitenedRows:
        """Some of the rows."""


@dataclass(frozen=True, eq=False)
class Whitened:
    """A linear problem multiplied by the symmetric root of R^-1.

    Attributes
    ----------
    v : ndarray, shape (n, M)
        Whitened left-hand side.
    A : ndarray, shape (n, M, p)
        Whitened sensitivity.
    size : ndarray of int, shape (n,)
        Number of real components of each row.
    log_det : ndarray, shape (n,)
        log |R| of each row: a row's log-density is that of the law minus half of it.
    """

    v: FloatArray
    A: FloatArray
    size: IntArray
    log_det: FloatArray

    def residual(self, theta: FloatArray) -> FloatArray:
        """Whitened residuals v - A theta, shape (..., n, M) for theta (..., p)."""
        theta = np.asarray(theta, dtype=float)
        n, width, p = self.A.shape
        fitted = theta @ self.A.reshape(n * width, p).T
        return self.v - fitted.reshape(*theta.shape[:-1], n, width)

    def pull_back(self, theta: FloatArray, v: FloatArray) -> FloatArray:
        """A' v, shape (..., p) for v (..., n, M), the same at every theta."""
        return v.reshape(*v.shape[:-2], -1) @ self.A.reshape(-1, self.A.shape[-1])

    def part(self, chosen: slice) -> Whitened:
        """Some of the rows, no wider than they need."""
        size = self.size[chosen]
        m = int(size.max())
        return Whitened(self.v[chosen, :m], self.A[chosen, :m], size, self.log_det[chosen])


@dataclass(frozen=True, eq=False)
class LinearProblem:
    """Rows y = B theta + noise with scale matrix R: the linear registration problem.

    Parameters
    ----------
    y : ndarray, shape (n, m)
        Contrasts of reports.
    B : ndarray, shape (n, m, p)
        Sensitivity of the contrasts to the unknown biases.
    R : ndarray, shape (n, m, m)
        Scale matrix of the noise of each row (what the data sheets say).
    time : ndarray, shape (n,), optional
        Time of each row, seconds.
    names, units : sequence of str, optional
        Of the p unknowns; by default theta[0], theta[1], ... without units.
    size : ndarray of int, shape (n,), optional
        Number of real components of padded rows; by default all m.
    observed : Observability, optional
        Verdict reached elsewhere, where B itself carries noise that hides a lost rank.

    Raises
    ------
    InvalidInputError
        Mismatched shapes, NaN or infinity, R not positive definite, no row.
    """

    y: FloatArray
    B: FloatArray
    R: FloatArray
    time: FloatArray | None = None
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    size: IntArray | None = None
    observed: Observability | None = None

    def __post_init__(self) -> None:
        y = finite_array("y", self.y, (None, None))
        n, m = y.shape
        if n == 0 or m == 0:
            raise InvalidInputError("the problem has no row: no target was seen in common.")
        B = finite_array("B", self.B, (n, m, None))
        R = positive_definite("R", finite_array("R", self.R, (n, m, m)))
        p = B.shape[2]
        names = tuple(self.names or (f"theta[{k}]" for k in range(p)))
        units = tuple(self.units or ("",) * p)
        if len(names) != p or len(units) != p or len(set(names)) != p:
            raise InvalidInputError(
                f"{p} unknowns need {p} different names and {p} units; got {names}, {units}."
            )
        size = np.full(n, m) if self.size is None else np.asarray(self.size)
        _check_padding(y, B, R, size)
        fields = {"y": y, "B": B, "R": R, "names": names, "units": units, "size": size}
        for name, value in fields.items():
            object.__setattr__(self, name, value)
        if self.time is not None:
            object.__setattr__(self, "time", finite_array("time", self.time, (n,)))

    @property
    def linear(self) -> bool:
        """True: the rows do not depend on theta."""
        return True

    @property
    def start(self) -> FloatArray:
        """Zero, shape (p,)."""
        return np.zeros(len(self.names))

    @property
    def scale(self) -> FloatArray:
        """One metre or one milliradian for each unknown, shape (p,)."""
        return bias_scale(self.units)

    @property
    def prior_sd(self) -> FloatArray:
        """100 m, 1 degree, 0.5 s or 1e-3 by unit, 1 where there is none, shape (p,)."""
        return np.array([_PRIOR_SD.get(unit, 1.0) for unit in self.units])

    @property
    def exact(self) -> Whitened:
        """The whitened rows."""
        return self._whitened

    def shifted(self, row: int, component: int, by: float) -> LinearProblem:
        """The same problem with y[row, component] moved by `by`."""
        y = self.y.copy()
        y[row, component] += by
        return replace(self, y=y)

    def residual(self, theta: FloatArray) -> FloatArray:
        """Residuals y - B theta, shape (n, m)."""
        return self.y - self.B @ np.asarray(theta, dtype=float)

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Derivative -B, shape (n, m, p)."""
        return -self.B

    def linearise(self, theta: FloatArray) -> LinearProblem:
        """The problem itself."""
        return self

    def whitened(self) -> Whitened:
        """Multiply by the symmetric root of R^-1 (kept after the first call)."""
        return self._whitened

    @cached_property
    def _whitened(self) -> Whitened:
        assert self.size is not None
        root, log_det = inverse_roots(np.ascontiguousarray(self.R))
        bad = np.flatnonzero(~np.isfinite(root).all(axis=(1, 2)))
        if bad.size:
            raise InvalidInputError(
                f"R[{bad[0]}] is numerically singular: its entries differ by more than double "
                "precision holds. Check the units and accuracies of the sensors."
            )
        v = np.einsum("nij,nj->ni", root, self.y)
        return Whitened(v, root @ self.B, self.size, log_det)

    def observability(self, theta: FloatArray | None = None) -> Observability:
        """Singular values and unobservable combinations by name; theta is not needed."""
        return self._observability

    @cached_property
    def _observability(self) -> Observability:
        if self.observed is not None:
            return self.observed
        return observability_of(self._whitened.A.reshape(-1, len(self.names)), self.names)


def bias_scale(units: tuple[str, ...]) -> FloatArray:
    """1 m, 1 mrad, 10 ms or 1e-4 in proportion by unit, 1 where there is none, shape (p,)."""
    return np.array([_SCALES.get(unit, 1.0) for unit in units])


def _check_padding(y: FloatArray, B: FloatArray, R: FloatArray, size: IntArray) -> None:
    """Raise unless `size` fits and the components beyond it carry no information."""
    n, m = y.shape
    whole = size.shape == (n,) and np.issubdtype(size.dtype, np.integer)
    if not whole or size.min() < 1 or size.max() > m:
        raise InvalidInputError(f"size must give 1 to {m} real components for each row.")
    blank = np.arange(m) >= size[:, None]
    if not blank.any():
        return
    neutral = np.where(blank[:, :, None] | blank[:, None, :], np.eye(m), R)
    wrong = (y != 0.0) & blank | (B != 0.0).any(axis=2) & blank | (neutral != R).any(axis=2)
    if wrong.any():
        raise InvalidInputError(
            f"row {np.flatnonzero(wrong.any(axis=1))[0]} is padded with numbers that count: beyond "
            "`size`, y and B must be 0 and R the identity."
        )
