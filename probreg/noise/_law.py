"""What every noise law shares: scaling, components, quadrature, compiled weights.

A law is a spherical density of the whitened residual v in m dimensions, written through
its log kernel g(d2, m) with d2 = |v|^2. Its equivalent weight is w = -2 dg / d(d2): the
weight that makes a least-squares step a step on the law's log-likelihood. A law gives both
as scalar functions, compiled once and the same in recursions and in batch, its sampler and,
where known in closed form, its normaliser and variance.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self

import numpy as np

from probreg.errors import ImproperLawError, InvalidInputError
from probreg.noise._compiled import LawNumbers, apply_each, apply_same, compile_scalar
from probreg.noise._radial import radial_integral
from probreg.noise._support import POSITIVE, Support
from probreg.typing import FloatArray, IntArray

Size = int | FloatArray | IntArray


class NoiseLaw(ABC):
    """Base of the noise laws; subclasses are frozen dataclasses over `scale` and their own.

    A new law must give what is abstract here: the fields `scale` and `componentwise` (with
    defaults), `weight_function`, `kernel_function` and `sample_unit`. It gives `params` where
    it has parameters of its own, with `parameter_slope` where these may be unknown
    (`supports`), and closed forms where they are known. A law that is Gaussian given a hidden
    precision is a `ScaleMixture`; one without a density is a `RejectionRule`.

    Attributes
    ----------
    proper : bool
        Whether a normalised density exists.
    convex : bool
        Whether minus the log kernel is convex, so that a mode has no rivals.
    scale_mixture : bool
        Whether the law is Gaussian given a random precision (`draw_precision`).
    kinked : bool
        Whether the score w |v| jumps or nearly does, so that its slope at single residuals
        says nothing about its mean slope.
    unit_name : str
        Field that holds the common noise scale.
    supports : mapping of str to Support
        Parameters that may be unknown, where they may lie, and how wide their usual priors are.
    """

    proper: ClassVar[bool] = True
    convex: ClassVar[bool] = True
    scale_mixture: ClassVar[bool] = False
    kinked: ClassVar[bool] = False
    unit_name: ClassVar[str] = "scale"
    supports: ClassVar[Mapping[str, Support]] = {"scale": POSITIVE}

    # -- what every law gives ------------------------------------------------------------

    @property
    @abstractmethod
    def scale(self) -> Any:
        """Factor on the square root of R, one number or one a chain."""

    @property
    @abstractmethod
    def componentwise(self) -> bool:
        """Whether every whitened component is weighed on its own."""

    @staticmethod
    @abstractmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """Equivalent weight at unit scale of one squared norm in m dimensions; is compiled."""

    @staticmethod
    @abstractmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """Unnormalised log-density at unit scale; analytic in d2 between its corners.

        One expression that serves arrays (`log_kernel`) and, compiled, single rows.
        """

    @abstractmethod
    def sample_unit(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """Draw n vectors of m components at unit scale, shape (n, m)."""

    # -- what a law gives where there is something to say --------------------------------

    @property
    def params(self) -> tuple[Any, ...]:
        """Numbers (or arrays that broadcast over chains) passed to the weight."""
        return ()

    @property
    def corners(self) -> tuple[float, ...]:
        """Radii where the kernel changes its formula or scale: quadrature splits there."""
        return (1.0, 10.0)

    def parameter_slope(self, name: str, d2: FloatArray, m: Size) -> FloatArray:
        """Derivative of the normalised unit-scale log-density by a parameter of its own."""
        raise InvalidInputError(f"{type(self).__name__} has no unknown parameter {name!r}.")

    def log_normalizer(self, m: int) -> FloatArray | float:
        """Log of the integral of exp(log_kernel) over R^m, by quadrature over the radius."""
        return np.log(self.radial_integral(lambda d2: np.ones_like(d2), m))

    def unit_covariance_factor(self, m: int) -> FloatArray | float:
        """E |v|^2 / m at unit scale, by quadrature over the radius."""
        return self.radial_integral(lambda d2: d2, m) / (m * np.exp(self.log_normalizer(m)))

    def unit_information_factor(self, m: int) -> float:
        """E (w |v|)^2 / m at unit scale, by quadrature over the radius."""
        moment = self.radial_integral(lambda d2: d2 * self.unit_weight(d2, m) ** 2, m)
        return moment / (m * float(np.exp(self.log_normalizer(m))))

    @property
    def unit(self) -> Any:
        """The common noise scale: residuals are divided by it first."""
        return self.scale

    # -- what follows from it ----------------------------------------------------------

    def log_kernel(self, d2: Any, m: Size) -> Any:
        """`kernel_function` of arrays of squared norms, with the law's own parameters."""
        return self.kernel_function(d2, m, self.params or (0.0,))

    @property
    def constants(self) -> FloatArray:
        """The parameters as compiled loops take them, for laws of one number each."""
        return np.array(self.params or (0.0,), dtype=float)

    @property
    def numbers(self) -> LawNumbers:
        """Parameters and unit as compiled loops take them, for laws of one number each."""
        return LawNumbers(self.constants, float(self.unit))

    @property
    def compiled_weight(self) -> Any:
        """`weight_function` in machine code, for compiled loops."""
        return compile_scalar(self.weight_function)

    @property
    def compiled_kernel(self) -> Any:
        """`kernel_function` in machine code, for compiled loops."""
        return compile_scalar(self.kernel_function)

    def squared_norm(self, v: FloatArray, m: Size | None = None) -> tuple[FloatArray, Size]:
        """Squared scaled residuals the law acts on, and their dimension.

        Parameters as for `log_density`.
        """
        v = np.asarray(v, dtype=float)
        if self.componentwise:
            return v**2 / np.asarray(self.unit) ** 2, 1
        size = v.shape[-1] if m is None else m
        return np.einsum("...m,...m->...", v, v) / np.asarray(self.unit) ** 2, size

    def log_density(self, v: FloatArray, m: Size | None = None) -> FloatArray:
        """Normalised log-density of whitened residuals.

        Parameters
        ----------
        v : ndarray, shape (..., M)
            Whitened residuals.
        m : int or ndarray, optional
            True number of components of rows padded with zeros; default M.

        Returns
        -------
        ndarray, shape (...)

        Raises
        ------
        ImproperLawError
            The law has no density.
        """
        if not self.proper:
            raise ImproperLawError(self._no_density("evaluated"))
        law = self._spread()
        d2, size = law.squared_norm(v, m)
        value = law.log_kernel(d2, size) - law._log_normalizers(size)
        value = value - np.asarray(size) * np.log(np.asarray(law.unit, dtype=float))
        return self._over_components(value, v, m)

    def log_density_slope(self, name: str, v: FloatArray, m: Size | None = None) -> FloatArray:
        """Derivative of `log_density` by the parameter `name`, shape (...).

        Parameters
        ----------
        name : str
            One of `supports`.
        v, m
            As for `log_density`.
        """
        law = self._spread()
        d2, size = law.squared_norm(v, m)
        if name == self.unit_name:
            # the unit is a factor of every residual: d log f / d log(unit) = w d^2 - m
            value = (law.unit_weight(d2, size) * d2 - size) / np.asarray(law.unit)
        else:
            value = law.parameter_slope(name, d2, size)
        return self._over_components(value, v, m)

    def weight(self, v: FloatArray, m: Size | None = None) -> FloatArray:
        """Equivalent weights, shape (...), or (..., M) for component-wise laws.

        Parameters as for `log_density`.
        """
        law = self._spread()
        d2, size = law.squared_norm(v, m)
        return law.unit_weight(d2, size) / np.asarray(law.unit) ** 2

    def curvature(
        self, v: FloatArray, m: Size | None = None, bandwidth: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Second derivatives of minus the log-density across and along the residual.

        The Hessian in v is across (I - u u') + along u u' with u = v / |v|; across is the
        weight. Component-wise laws have a diagonal Hessian, which is along.

        Parameters
        ----------
        v, m
            As for `log_density`.
        bandwidth : float
            For kinked laws, the half-width of |v| over which the score is differenced: its
            mean slope over many residuals is then right. Other laws take a tiny step.

        Returns
        -------
        across, along : ndarray, shape (...), or (..., M) for component-wise laws
        """
        law = self._spread()
        d2, size = law.squared_norm(v, m)
        unit = np.asarray(law.unit)
        radius = np.sqrt(d2)
        step = bandwidth / unit if self.kinked and bandwidth else 1e-5 * np.maximum(radius, 1e-6)
        high, low = radius + step, radius - step
        rise = law.unit_weight(high**2, size) * high - law.unit_weight(low**2, size) * low
        return law.unit_weight(d2, size) / unit**2, rise / (2.0 * step) / unit**2

    def sample(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """Draw n whitened residuals of m components, shape (n, m).

        Raises
        ------
        ImproperLawError
            The law has no density.
        """
        if self.componentwise:
            return float(self.unit) * self.sample_unit(rng, n * m, 1).reshape(n, m)
        return float(self.unit) * self.sample_unit(rng, n, m)

    def covariance_factor(self, m: int) -> FloatArray | float:
        """Covariance of the whitened residual divided by the identity; may be infinite."""
        if not self.proper:
            raise ImproperLawError(self._no_density("asked for its variance"))
        return self.unit**2 * self.unit_covariance_factor(1 if self.componentwise else m)

    def information_factor(self, m: int) -> float:
        """Fisher information of the location of v divided by the identity: E (w |v|)^2 / m."""
        if not self.proper:
            raise ImproperLawError(self._no_density("asked for its information"))
        size = 1 if self.componentwise else m
        return float(self.unit_information_factor(size) / self.unit**2)

    def radial_integral(self, function: Callable[[FloatArray], FloatArray], m: int) -> float:
        """Integral over R^m of function(|v|^2) exp(log_kernel), scalar parameters only."""
        return radial_integral(lambda d2: self.log_kernel(d2, m), function, m, self.corners)

    def unit_weight(self, d2: FloatArray, m: Size) -> FloatArray:
        """Weights at unit scale of squared norms in m dimensions, by the compiled function."""
        weight = self.compiled_weight
        if np.ndim(m) == 0 and not any(np.ndim(value) for value in self.params):
            flat = np.ascontiguousarray(d2, dtype=float).ravel()
            return apply_same(weight, flat, float(m), self.constants).reshape(np.shape(d2))
        parts = np.broadcast_arrays(d2, np.asarray(m, dtype=float), *(self.params or (0.0,)))
        columns = [np.array(part, dtype=float).ravel() for part in parts]
        params = np.stack(columns[2:], axis=-1)
        return apply_each(weight, columns[0], columns[1], params).reshape(parts[0].shape)

    # -- details -----------------------------------------------------------------------

    def _spread(self) -> Self:
        """Append an axis to array parameters of a component-wise law: chains, rows, components."""
        if not self.componentwise:
            return self
        fields = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}  # type: ignore[arg-type]
        arrays = {k: np.asarray(v)[..., None] for k, v in fields.items() if np.ndim(v) > 0}
        return dataclasses.replace(self, **arrays) if arrays else self  # type: ignore[type-var]

    def _over_components(self, value: Any, v: FloatArray, m: Size | None) -> FloatArray:
        """Rows as they are; of a component-wise law the sum over the real components."""
        if not self.componentwise:
            return np.asarray(value)
        width = np.shape(v)[-1]
        real = np.asarray(width if m is None else m)
        return np.where(np.arange(width) < real[..., None], value, 0.0).sum(axis=-1)

    def _log_normalizers(self, m: Size) -> Any:
        if np.ndim(m) == 0:
            return self.log_normalizer(int(m))
        sizes = np.asarray(m)
        return sum(
            np.where(sizes == size, self.log_normalizer(int(size)), 0.0)
            for size in np.unique(sizes)
        )

    def _no_density(self, what: str) -> str:
        return (
            f"{type(self).__name__} is a rejection rule without a normalisable density, so it "
            f"cannot be {what}. Use it in an estimator, or take a proper law (Gaussian, "
            "StudentT, Contaminated, Hyperbolic, Huber)."
        )


def per_component(weights: FloatArray, v: FloatArray) -> FloatArray:
    """Weights (..., n) or (..., n, M) as an array that multiplies v (..., n, M)."""
    per_row = weights[..., None] if weights.ndim < v.ndim else weights
    return np.broadcast_to(per_row, v.shape)
