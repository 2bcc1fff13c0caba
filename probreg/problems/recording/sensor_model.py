"""A sensor as the track model sees it: its kind of report, its noise, its systematic errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from probreg.errors import InvalidInputError
from probreg.sensors.axes import Axes
from probreg.typing import FloatArray
from probreg.validation import finite_array


class ErrorTerm(Protocol):
    """A systematic error, linear in one unknown coefficient."""

    @property
    def stamp(self) -> float:
        """Derivative of the report's time stamp by the coefficient."""

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
    """

    axes: Axes
    sigmas: FloatArray
    terms: tuple[tuple[int, ErrorTerm], ...] = ()
    own: tuple[tuple[int, ErrorTerm], ...] = ()

    def __post_init__(self) -> None:
        q = len(self.axes.angles)
        sigmas = finite_array("sigmas", self.sigmas, (q,))
        if (sigmas <= 0.0).any():
            raise InvalidInputError(f"sigmas {sigmas} must be above zero.")
        object.__setattr__(self, "sigmas", sigmas)
