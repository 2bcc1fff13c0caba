"""The one place where a problem, a noise law and priors meet."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.errors import ImproperLawError, InvalidInputError
from probreg.noise import NoiseLaw, per_component, require_scalar_law
from probreg.posterior._blocks import row_blocks, sizes
from probreg.posterior.laplace import Laplace, climb, joint_covariance, require_mode
from probreg.posterior.weighted_fit import Mode, WeightedFit
from probreg.prior import GaussianPrior, NoiseParameter
from probreg.problems.linear import LinearProblem, Problem, WhitenedRows
from probreg.typing import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Posterior:
    """Posterior of constant unknowns: rows under a noise law, with priors.

    A nonlinear problem enters exactly where it can (`exact`: bearings), else through its
    linear form at the mode (polar reports, whose R changes with the bias).

    Its coordinates are *free*: the unknowns of the problem as they are, followed by one
    coordinate on the whole line for each unknown parameter of the noise law (a log or
    logit). `natural` gives the parameters themselves. Without unknown noise parameters the
    two are the same.

    Parameters
    ----------
    problem : Problem
        Linear or nonlinear.
    noise : NoiseLaw
        Law of the whitened residuals. An improper law has weights and hence a mode, but no
        density: asking for one raises ImproperLawError.
    prior : GaussianPrior, optional
        On the problem's unknowns; by default flat, and the data must then determine them.
    noise_prior : tuple of NoiseParameter
        Parameters of the law that are unknown too, with their priors.
    box : ndarray, shape (p, 2), optional
        Lower and upper bounds of the problem's unknowns; the density is zero outside.

    Raises
    ------
    InvalidInputError
        A prior whose length does not fit, a noise parameter that the law has not, a box that
        is empty.
    UnobservableError
        Without a prior: combinations that the data do not determine, by name.
    """

    problem: Problem
    noise: NoiseLaw
    prior: GaussianPrior | None = None
    noise_prior: tuple[NoiseParameter, ...] = ()
    box: FloatArray | None = None

    def __post_init__(self) -> None:
        if isinstance(self.noise_prior, NoiseParameter):
            object.__setattr__(self, "noise_prior", (self.noise_prior,))
        self.fit  # noqa: B018  refuse an undetermined problem now, not in mid-run
        require_scalar_law(self.noise)
        _check_noise_prior(self.noise, self.noise_prior)
        if self.box is not None:
            object.__setattr__(self, "box", _checked_box(self.box, self.problem.names))

    # -- coordinates -------------------------------------------------------------------

    @property
    def dim_theta(self) -> int:
        """Number of unknowns of the problem."""
        return len(self.problem.names)

    @property
    def dim(self) -> int:
        """Number of free coordinates, d."""
        return self.dim_theta + len(self.noise_prior)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns, those of the law as "noise.nu"."""
        return (*self.problem.names, *(f"noise.{p.name}" for p in self.noise_prior))

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the unknowns."""
        return (*self.problem.units, *("",) * len(self.noise_prior))

    def natural(self, x: FloatArray) -> FloatArray:
        """Natural values (..., d) of free coordinates (..., d)."""
        values = np.array(x, dtype=float)
        for k, parameter in enumerate(self.noise_prior, self.dim_theta):
            support = self.noise.supports[parameter.name]
            values[..., k] = support.natural(values[..., k])
        return values

    def free(self, values: FloatArray) -> FloatArray:
        """Free coordinates (..., d) of natural values (..., d)."""
        x = np.array(values, dtype=float)
        for k, parameter in enumerate(self.noise_prior, self.dim_theta):
            x[..., k] = self.noise.supports[parameter.name].free(x[..., k])
        return x

    def law(self, x: FloatArray) -> NoiseLaw:
        """The noise law at free coordinates (..., d), its unknown parameters (..., 1)."""
        if not self.noise_prior:
            return self.noise
        values = self.natural(x)
        changed = {
            parameter.name: values[..., k, None] if values.ndim > 1 else float(values[k])
            for k, parameter in enumerate(self.noise_prior, self.dim_theta)
        }
        return dataclasses.replace(self.noise, **changed)  # type: ignore[type-var]

    def inside(self, x: FloatArray) -> BoolArray:
        """Whether free coordinates (..., d) lie in the box, shape (...)."""
        theta = np.asarray(x)[..., : self.dim_theta]
        if self.box is None:
            return np.ones(theta.shape[:-1], dtype=bool)
        return np.asarray(((theta >= self.box[:, 0]) & (theta <= self.box[:, 1])).all(axis=-1))

    # -- least squares: the part that needs no density -----------------------------------

    @cached_property
    def fit(self) -> WeightedFit:
        """Reweighted least squares on the same rows, the law as it is."""
        return WeightedFit(self.problem, self.noise, self.prior)

    @property
    def linear(self) -> LinearProblem:
        """The linear problem that is tangent at the mode."""
        return self.fit.linear

    def mode(
        self, start: FloatArray | None = None, max_iterations: int = 500, tolerance: float = 1e-8
    ) -> Mode:
        """Mode of the problem's unknowns under the law as it is: `WeightedFit.mode`."""
        return self.fit.mode(start, max_iterations, tolerance)

    def laplace_covariance(self, mode: Mode) -> FloatArray:
        """Inverse Hessian (p, p) at such a mode: `WeightedFit.laplace_covariance`."""
        return self.fit.laplace_covariance(mode)

    # -- densities ---------------------------------------------------------------------

    @cached_property
    def rows(self) -> WhitenedRows:
        """The whitened rows that the densities use."""
        return self.linear.whitened() if self.problem.exact is None else self.problem.exact

    def log_likelihood(self, x: FloatArray) -> FloatArray:
        """Log-density of every row, shape (..., n), for free coordinates (..., d)."""
        x = self._check(x)
        rows = self.rows
        v = rows.residual(x[..., : self.dim_theta])
        return self.law(x).log_density(v, sizes(rows)) - 0.5 * rows.log_det

    def log_prior(self, x: FloatArray) -> FloatArray:
        """Log prior density of free coordinates (..., d), shape (...); flat parts count zero."""
        x = self._check(x)
        value = np.zeros(x.shape[:-1])
        if self.prior is not None:
            value = value + self.prior.log_density(x[..., : self.dim_theta])
        for k, parameter in enumerate(self.noise_prior, self.dim_theta):
            value = value + parameter.log_density(x[..., k], self.noise)
        return np.where(self.inside(x), value, -np.inf)

    def log_prob(self, x: FloatArray) -> FloatArray:
        """Log-posterior up to the evidence, shape (...), for free coordinates (..., d)."""
        x = self._check(x)
        law, value = self.law(x), self.log_prior(x)
        for rows in row_blocks(self.rows, value.size):
            v = rows.residual(x[..., : self.dim_theta])
            value = value + law.log_density(v, sizes(rows)).sum(axis=-1)
        return value - 0.5 * self._log_det

    def grad_log_prior(self, x: FloatArray) -> FloatArray:
        """Gradient of `log_prior` inside the box, shape (..., d)."""
        x = self._check(x)
        value = np.zeros(x.shape)
        if self.prior is not None:
            away = self.prior.mean - x[..., : self.dim_theta]
            value[..., : self.dim_theta] = away @ self.prior.precision
        for k, parameter in enumerate(self.noise_prior, self.dim_theta):
            value[..., k] = parameter.log_density_slope(x[..., k], self.noise)
        return value

    def grad_log_prob(self, x: FloatArray) -> FloatArray:
        """Gradient of `log_prob`, shape (..., d); that of the untruncated density outside."""
        return self.log_prob_and_grad(x)[1]

    def log_prob_and_grad(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """`log_prob` and its gradient, the residuals computed once."""
        value, gradient = self.likelihood_and_grad(x)
        return value + self.log_prior(x), gradient + self.grad_log_prior(x)

    def likelihood_and_grad(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Sum of the rows' log-densities, shape (...), and its gradient (..., d)."""
        x = self._check(x)
        theta, law = x[..., : self.dim_theta], self.law(x)
        value, gradient = np.full(x.shape[:-1], -0.5 * self._log_det), np.zeros(x.shape)
        for rows in row_blocks(self.rows, value.size):
            v, size = rows.residual(theta), sizes(rows)
            value = value + law.log_density(v, size).sum(axis=-1)
            weighted = per_component(law.weight(v, size), v) * v
            gradient[..., : self.dim_theta] += rows.pull_back(theta, weighted)
            for k, parameter in enumerate(self.noise_prior, self.dim_theta):
                slope = law.log_density_slope(parameter.name, v, size).sum(axis=-1)
                gradient[..., k] += slope * self.noise.supports[parameter.name].slope(x[..., k])
        return value, gradient

    def to_pyro(self) -> Callable[[], None]:
        """The same model as an ordinary Pyro model, to be extended there.

        Sites: "theta" (p,), "noise.<name>.free" for each unknown noise parameter (and the
        parameter itself as deterministic "noise.<name>"), and the factor "rows".
        """
        from probreg.posterior.torch_bridge import pyro_model

        return pyro_model(self, self.prior, self.noise, self.noise_prior)

    @cached_property
    def laplace(self) -> Laplace:
        """Gaussian approximation at the joint mode.

        Raises
        ------
        InvalidInputError
            The mode lies outside the box, or the density is not finite or not curved downwards
            there.
        """
        first, unknown = self.mode(), self.noise_prior
        if not unknown:
            require_mode(self, first.theta)
            return Laplace.at(first.theta, self.laplace_covariance(first))
        spread = np.array([parameter.spread for parameter in unknown])
        start = np.append(first.theta, [p.free_median(self.noise) for p in unknown])
        unit = np.append(np.sqrt(np.diag(self.laplace_covariance(first))), spread)
        uncut = self if self.box is None else dataclasses.replace(self, box=None)
        mode = climb(uncut, start, unit)
        require_mode(self, mode)
        fixed = WeightedFit(self.problem, self.law(mode), self.prior)
        known = fixed.hessian(fixed.mode(mode[: self.dim_theta]))
        return Laplace.at(mode, joint_covariance(self, mode, known, 1e-4 * spread))

    # -- details -----------------------------------------------------------------------

    def _check(self, x: FloatArray) -> FloatArray:
        x = np.asarray(x, dtype=float)
        if x.ndim == 0 or x.shape[-1] != self.dim:
            raise InvalidInputError(
                f"theta has shape {x.shape}; its last axis must hold {', '.join(self.names)}."
            )
        return x

    @cached_property
    def _log_det(self) -> float:
        return float(self.rows.log_det.sum())


def _check_noise_prior(noise: NoiseLaw, noise_prior: tuple[NoiseParameter, ...]) -> None:
    """Raise unless the law has a density and each parameter, and each has one prior."""
    names = [parameter.name for parameter in noise_prior]
    if len(set(names)) != len(names):
        raise InvalidInputError(f"a noise parameter has two priors: {names}.")
    for parameter in noise_prior:
        parameter.check(noise)
    if noise_prior and not noise.proper:
        raise ImproperLawError(
            f"{type(noise).__name__} has no density, so its parameters have no posterior. Take a "
            "proper law."
        )


def _checked_box(given: FloatArray, names: tuple[str, ...]) -> FloatArray:
    """Bounds (p, 2) of the unknowns."""
    box = np.asarray(given, dtype=float)
    fits = box.shape == (len(names), 2) and not np.isnan(box).any()
    if not fits or np.any(box[:, 0] >= box[:, 1]):
        raise InvalidInputError(
            f"box must be ({len(names)}, 2), lower below upper, for {', '.join(names)}; got "
            f"{box.tolist()}."
        )
    return box
