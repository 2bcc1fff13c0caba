"""Which combinations of the unknowns the data determine, by name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from probreg.errors import UnobservableError
from probreg.typing import FloatArray

RANK_TOLERANCE = 1e-7  # relative singular value; below, normal equations lose every digit
INFORMATION_TOLERANCE = 1e-3  # of singular values whose squares alone are known


@dataclass(frozen=True, eq=False)
class Observability:
    """Singular values of the whitened sensitivity, and the combinations it does not see.

    Attributes
    ----------
    singular_values : ndarray, shape (p,)
        Of the matrix with columns scaled to unit length, largest first.
    null_space : ndarray, shape (k, p)
        One unobservable combination a row, in the problem's units; each owns an unknown that
        the others leave out.
    names : tuple of str
        Parameter names.
    equations : int
        Number of scalar equations.
    advice : str
        What to do about a combination that is not seen.
    """

    singular_values: FloatArray
    null_space: FloatArray
    names: tuple[str, ...]
    equations: int
    advice: str = "Add targets in other directions, fix a reference sensor,"

    @property
    def complete(self) -> bool:
        """Whether every combination is determined."""
        return len(self.null_space) == 0

    def combinations(self) -> list[str]:
        """The unobservable combinations, written out: "a.range + b.range"."""
        return [_spell(row, self.names) for row in self.null_space]

    def require(self) -> None:
        """Raise UnobservableError unless everything is determined."""
        if self.complete:
            return
        listing = "; ".join(self.combinations())
        few = ""
        if self.equations < len(self.names):
            few = f"there are {self.equations} equations for {len(self.names)} unknowns. "
        raise UnobservableError(
            f"the data do not determine {len(self.null_space)} combination(s) of the unknowns: "
            f"{few}Moving along {listing} changes no residual. {self.advice} or give a prior "
            "(GaussianPrior)."
        )


def observability_of(sensitivity: FloatArray, names: tuple[str, ...]) -> Observability:
    """Find the rank and null space of a stacked whitened sensitivity, shape (rows, p)."""
    p = sensitivity.shape[1]
    length = np.linalg.norm(sensitivity, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    # singular values of the triangular factor: exact to rounding, unlike those of A'A
    triangle = np.linalg.qr(sensitivity / length, mode="r")
    _, values, right = np.linalg.svd(triangle, full_matrices=True)
    values = np.concatenate([values, np.zeros(p - values.size)])
    hidden = right[values <= RANK_TOLERANCE * max(values[0], np.finfo(float).tiny)]
    return Observability(values, _sparse_rows(hidden) / length, names, len(sensitivity))


def _sparse_rows(rows: FloatArray) -> FloatArray:
    """Rotate a null-space basis so that each row owns one coordinate: readable by name."""
    if len(rows) == 0:
        return rows
    pivots = linalg.qr(rows, mode="r", pivoting=True)[1][: len(rows)]
    basis = np.linalg.solve(rows[:, pivots], rows)
    return np.where(np.abs(basis) < 1e-6, 0.0, basis)


def _spell(row: FloatArray, names: tuple[str, ...]) -> str:
    row = row / row[np.argmax(np.abs(row))]
    text = ""
    for value, name in zip(row, names, strict=True):
        if value == 0.0:
            continue
        size = "" if np.isclose(abs(value), 1.0) else f"{abs(value):.3g} "
        sign = ("-" if value < 0.0 else "") if not text else (" - " if value < 0.0 else " + ")
        text += f"{sign}{size}{name}"
    return text


def observability_of_information(
    information: FloatArray, names: tuple[str, ...], equations: int
) -> Observability:
    """Find the rank and null space of information (p, p) = A' A of a sensitivity A.

    Rounding and weak priors of what was eliminated leave traces, so what is seen a thousand
    times more weakly than the rest counts as not seen.
    """
    length = np.sqrt(np.diag(information))
    length = np.where(length > 0.0, length, 1.0)
    squares, vectors = np.linalg.eigh(information / np.outer(length, length))
    values = np.sqrt(np.maximum(squares[::-1], 0.0))
    right = vectors[:, ::-1].T
    hidden = right[values <= INFORMATION_TOLERANCE * max(values[0], np.finfo(float).tiny)]
    return Observability(values, _sparse_rows(hidden) / length, names, equations)
