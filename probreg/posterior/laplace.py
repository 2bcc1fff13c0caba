"""The Gaussian approximation of a posterior at its joint mode."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import linalg

from probreg.errors import InvalidInputError
from probreg.posterior.reweighting import Mode, Reweighted
from probreg.typing import FloatArray

if TYPE_CHECKING:
    from probreg.posterior.posterior import Posterior


@dataclass(frozen=True, eq=False)
class Laplace:
    """The Gaussian approximation at the mode, in free coordinates.

    Attributes
    ----------
    mean : ndarray, shape (d,)
    covariance : ndarray, shape (d, d)
    root : ndarray, shape (d, d)
        Lower triangular, covariance = root root'.
    """

    mean: FloatArray
    covariance: FloatArray
    root: FloatArray


def approximate(posterior: Posterior) -> Laplace:
    """Mode and curvature of a posterior in free coordinates.

    Raises
    ------
    InvalidInputError
        The mode lies outside the box, or the density is not finite or not curved downwards
        there.
    """
    first = posterior.mode()
    mode = joint_mode(posterior, first)
    if not posterior.inside(mode):
        theta = mode[: posterior.dim_theta]
        where = ", ".join(
            f"{name} {value:.4g}"
            for name, value in zip(posterior.problem.names, theta, strict=True)
        )
        raise InvalidInputError(
            f"the box excludes the mode ({where}), so a sampler would only see a tail of the "
            "posterior. Widen the box, or say in a prior what you know."
        )
    with np.errstate(over="ignore", invalid="ignore"):
        height = float(posterior.log_prob(mode))
    if not np.isfinite(height):
        raise InvalidInputError(
            f"the log-density at the mode is {height}: nothing can start there. Check the "
            "reports for absurd values and the priors for their scale."
        )
    covariance = joint_covariance(posterior, first, mode)
    return Laplace(mode, covariance, np.linalg.cholesky(covariance))


def joint_mode(posterior: Posterior, first: Mode) -> FloatArray:
    """Mode (d,) of all free coordinates, wherever the box ends, from that under the law as is."""
    unknown = posterior.noise_prior
    x = np.concatenate([first.theta, [p.free_median(posterior.noise) for p in unknown]])
    if not unknown:
        return x
    covariance = posterior.laplace_covariance(first)
    unit = np.concatenate([np.sqrt(np.diag(covariance)), [p.spread for p in unknown]])
    unbounded = posterior if posterior.box is None else dataclasses.replace(posterior, box=None)

    def objective(z: FloatArray) -> tuple[float, FloatArray]:
        value, gradient = unbounded.log_prob_and_grad(x + unit * z)
        return -float(value), -unit * gradient

    from scipy import optimize  # slow to import, needed only here

    found = optimize.minimize(objective, np.zeros(len(x)), jac=True, method="BFGS")
    return x + unit * found.x


def joint_covariance(posterior: Posterior, first: Mode, mode: FloatArray) -> FloatArray:
    """Inverse Hessian: of the problem's unknowns as by IRLS, of the law's by differences."""
    if not posterior.noise_prior:
        return posterior.laplace_covariance(first)
    p = posterior.dim_theta
    fixed = Reweighted(posterior.problem, posterior.law(mode), posterior.prior)
    precision = np.zeros((posterior.dim, posterior.dim))
    precision[:p, :p] = fixed.hessian(fixed.mode(mode[:p]))
    step = 1e-4 * np.array([parameter.spread for parameter in posterior.noise_prior])
    ends = np.repeat(mode[None], 2 * len(step), axis=0)
    for k, h in enumerate(step):
        ends[2 * k, p + k] += h
        ends[2 * k + 1, p + k] -= h
    slopes = posterior.grad_log_prob(ends)
    across = -(slopes[::2] - slopes[1::2]) / (2.0 * step[:, None])
    precision[p:, :p], precision[:p, p:] = across[:, :p], across[:, :p].T
    precision[p:, p:] = 0.5 * (across[:, p:] + across[:, p:].T)
    try:
        scale = np.sqrt(np.diag(precision))
        inverse = linalg.inv(precision / np.outer(scale, scale)) / np.outer(scale, scale)
        np.linalg.cholesky(inverse)
    except (linalg.LinAlgError, ValueError):
        raise InvalidInputError(
            "the log-posterior is not curved downwards at its mode in the noise parameters; "
            "give them tighter priors or fix them."
        ) from None
    covariance: FloatArray = 0.5 * (inverse + inverse.T)
    return covariance
