"""Taking terms out of reports, and putting them back exactly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors.terms._term import Term
from probreg.typing import FloatArray

_PASSES = 100
_ROUNDING = 4.0 * float(np.finfo(float).eps)


def displacement(terms: Sequence[Term], theta: FloatArray, reports: FloatArray) -> FloatArray:
    """What the terms add to true reports (n, q), for coefficients (k,) or (k, n, 1)."""
    moved = np.zeros(np.shape(reports))
    for term, coefficient in zip(terms, theta, strict=True):
        moved += coefficient * term.column(reports)
    return moved


def add_terms(terms: Sequence[Term], theta: FloatArray, reports: FloatArray) -> FloatArray:
    """Biased reports (n, q) of true reports (n, q), for coefficients (k,)."""
    return np.asarray(reports, dtype=float) + displacement(terms, theta, reports)


def remove_terms(terms: Sequence[Term], theta: FloatArray, reports: FloatArray) -> FloatArray:
    """True reports (n, q) whose biased ones are given: the fixed point c = z - sum theta g(c).

    Raises
    ------
    InvalidInputError
        Coefficients so large that no fixed point is found.
    """
    reports = np.asarray(reports, dtype=float)
    if not terms or len(reports) == 0:
        return reports
    corrected, size = reports, np.maximum(np.abs(reports), 1.0)
    for _ in range(_PASSES):
        before, corrected = corrected, reports - displacement(terms, theta, corrected)
        # components that are missing stay so
        if not (np.abs(corrected - before) > _ROUNDING * size).any():
            return corrected
    sizes = [np.max(np.abs(c)) if np.ndim(c) else c for c in theta]
    names = ", ".join(f"{t.owner}.{t.name} {c:.3g}" for t, c in zip(terms, sizes, strict=True))
    raise InvalidInputError(
        f"no correction reproduces the reports with {names}: these are not small biases."
    )
