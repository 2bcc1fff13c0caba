"""Laws in which a precision is hidden: Gaussian given it, so that Gibbs samplers can draw it."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Callable, Collection
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from probreg.noise._law import NoiseLaw, Size
from probreg.typing import FloatArray

LEAST_SHARE = 1e-40  # far residuals live on small shares
WEAK = 4.0  # components of noise that a nominal scale counts for


class Mixture(NamedTuple):
    """A law as a sum of Gaussians of m components, covariance `variance` times the identity.

    Attributes
    ----------
    share, variance : ndarray, shape (J,)
        Shares add up to one. A continuous mixture is a grid, fine enough for what a residual
        says of the precision.
    """

    share: FloatArray
    variance: FloatArray


class MixtureCounts(NamedTuple):
    """What residuals say of the Gaussians of a `Mixture`, in expectation.

    Attributes
    ----------
    rows, components, square : ndarray, shape (J,)
        Rows that are of each Gaussian, their components, and the sum of their squared noise.
    """

    rows: FloatArray
    components: FloatArray
    square: FloatArray


def on_grid(log_share: FloatArray, variance: FloatArray) -> Mixture:
    """Shares that add up to one; points without any are left out."""
    share = np.exp(log_share - log_share.max())
    seen = share > LEAST_SHARE
    return Mixture(share[seen] / share.sum(), variance[seen])


def log_grid(low: float, high: float, step: float = 0.5) -> FloatArray:
    """Points equally spaced in the logarithm: the trapezoid rule converges fast there."""
    edges = np.log([low, high])
    points: FloatArray = np.exp(np.arange(edges[0], edges[1] + step, step))
    return points


class ScaleMixture(NoiseLaw):
    """A law that is Gaussian given a positive random precision."""

    scale_mixture: ClassVar[bool] = True

    @abstractmethod
    def draw_unit_precision(self, rng: np.random.Generator, d2: FloatArray, m: Size) -> FloatArray:
        """Draw the precision given the squared norm, at unit scale."""

    @abstractmethod
    def unit_mixture(self, m: int) -> Mixture:
        """The law of m components at unit scale as a sum of Gaussians."""

    def mixture(self, m: int) -> Mixture:
        """The law of m components as a sum of Gaussians; scalar parameters only."""
        share, variance = self.unit_mixture(1 if self.componentwise else m)
        return Mixture(share, variance * float(self.unit) ** 2)

    def refitted(
        self, counts: MixtureCounts, m: int, unknown: Collection[str], about: Self
    ) -> Self:
        """The law at the parameters that expected counts suggest: a step of EM.

        Parameters
        ----------
        counts : MixtureCounts
            Of `mixture(m)` of this law.
        m : int
            Components of a row.
        unknown : collection of str
            Parameters that may change, of `supports`.
        about : ScaleMixture
            The law as it was given, about which weak priors keep what counts say nothing of.
        """
        return self._rescaled(*self._noise(counts, m), unknown, about, weak_scale)

    def draw_parameters(
        self,
        rng: np.random.Generator,
        counts: MixtureCounts,
        m: int,
        unknown: Collection[str],
        about: Self,
    ) -> Self:
        """The law at parameters drawn given which Gaussian each row is of: a Gibbs step.

        Priors and arguments are those of `refitted`.
        """

        def draw(square: float, components: float, nominal: float) -> float:
            return draw_scale(rng, square, components, nominal)

        return self._rescaled(*self._noise(counts, m), unknown, about, draw)

    def _noise(self, counts: MixtureCounts, m: int) -> tuple[float, float]:
        """Sum of squares at unit scale, and components."""
        relative = counts.square / self.unit_mixture(m).variance
        return float(relative.sum()), float(counts.components.sum())

    def _rescaled(
        self,
        square: float,
        components: float,
        unknown: Collection[str],
        about: Self,
        scale: Callable[[float, float, float], float],
    ) -> Self:
        if self.unit_name not in unknown:
            return self
        unit: dict[str, Any] = {self.unit_name: scale(square, components, float(about.unit))}
        return dataclasses.replace(self, **unit)  # type: ignore[type-var]

    def draw_precision(
        self, rng: np.random.Generator, v: FloatArray, m: Size | None = None
    ) -> FloatArray:
        """Draw the precisions of rows given their whitened residuals: the Gibbs step.

        Their conditional mean is the equivalent weight; shapes as for `weight`.
        """
        law = self._spread()
        d2, size = law.squared_norm(v, m)
        return law.draw_unit_precision(rng, d2, size) / np.asarray(law.unit) ** 2


def weak_scale(square: float, components: float, nominal: float) -> float:
    """Scale of noise from the sum of its squares: the mode in its logarithm.

    The prior is scaled inverse chi-square about `nominal`, of `WEAK` components.
    """
    return float(np.sqrt((square + WEAK * nominal**2) / (components + WEAK)))


def draw_scale(rng: np.random.Generator, square: float, components: float, nominal: float) -> float:
    """Draw a scale of noise given the sum of its squares, with the prior of `weak_scale`."""
    return float(np.sqrt((square + WEAK * nominal**2) / rng.chisquare(components + WEAK)))
