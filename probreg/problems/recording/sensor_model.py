"""A sensor as the track model sees it: its kind of report, its noise, its systematic errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors.axes import Axes
from probreg.typing import FloatArray
from probreg.validation import finite_array


class ErrorTerm(Protocol):
    """A systematic error, linear in one unknown coefficient."""

    @property
    def stamp(self) -> float:
        """Derivative of the report's time stamp by the coefficient."""

    @property
    def varies(self) -> bool:
        """Whether its effect depends on where the target is, or how it moves."""

    def column(self, reports: FloatArray) -> FloatArray:
        """Derivative (n, q) of true reports (n, q) by the coefficient."""


@dataclass(frozen=True, eq=False)
class SensorModel:
    """A sensor as the track model sees it.

    Parameters
    ----------
    axes : Axes
    sigmas : ndarray, shape (q,)
        Standard deviations of the components, metres and radians.
    terms : tuple of (int, ErrorTerm)
        Systematic errors, each with its place among the biases.
    own : tuple of (int, ErrorTerm)
        Errors that belong to the target and stay with it, each with its place among the
        constants of a target.
    azimuth : int, optional
        The component to which a heading adds.
    metric : tuple of bool, optional
        Components whose sigma is in metres whatever their unit; by default none.
    mixing : ndarray, shape (q, q), or None
        Rotation of the components' errors, in metres, into some that are independent: `sigmas`
        are those of the rotated ones. None where those of the components are.
    """

    axes: Axes
    sigmas: FloatArray
    terms: tuple[tuple[int, ErrorTerm], ...] = ()
    own: tuple[tuple[int, ErrorTerm], ...] = ()
    azimuth: int | None = None
    metric: tuple[bool, ...] = ()
    mixing: FloatArray | None = None

    def __post_init__(self) -> None:
        q = len(self.axes.angles)
        sigmas = finite_array("sigmas", self.sigmas, (q,))
        if (sigmas <= 0.0).any():
            raise InvalidInputError(f"sigmas {sigmas} must be above zero.")
        object.__setattr__(self, "sigmas", sigmas)
        if not self.metric:
            object.__setattr__(self, "metric", (False,) * q)

    @property
    def varies(self) -> bool:
        """Whether the effect of some term depends on the path."""
        return any(term.varies for _, term in self.terms)

    def mixed(self, parts: FloatArray) -> FloatArray:
        """Parts by component (n, q, ...), in metres, as parts whose errors are independent."""
        if self.mixing is None:
            return parts
        return np.asarray(np.einsum("pq,nq...->np...", self.mixing, parts))
