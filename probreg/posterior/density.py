"""What is asked of a posterior by those that need its density only."""

from __future__ import annotations

from typing import Protocol

from probreg.typing import BoolArray, FloatArray


class Density(Protocol):
    """A log-density over d free coordinates, as the Laplace approximation and torch see it."""

    @property
    def dim(self) -> int:
        """Number of free coordinates, d."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the d unknowns."""

    @property
    def box(self) -> FloatArray | None:
        """Bounds (p, 2) of the first p unknowns, outside which there is no density."""

    def inside(self, x: FloatArray) -> BoolArray:
        """Whether free coordinates (..., d) lie in the box, shape (...)."""

    def log_prob(self, x: FloatArray) -> FloatArray:
        """Log-density up to a constant, shape (...), of free coordinates (..., d)."""

    def log_prob_and_grad(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The same and its gradient (..., d), that of the density without a box."""

    def likelihood_and_grad(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The part of the log-density that is not prior, shape (...), and its gradient."""
