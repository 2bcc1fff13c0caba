"""The Gaussian approximation of a density at its mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from probreg.errors import InvalidInputError
from probreg.posterior.density import Density
from probreg.typing import FloatArray


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

    @classmethod
    def at(cls, mode: FloatArray, covariance: FloatArray) -> Laplace:
        """From a mode (d,) and the inverse curvature (d, d) there."""
        return cls(mode, covariance, np.linalg.cholesky(covariance))


def climb(density: Density, start: FloatArray, unit: FloatArray) -> FloatArray:
    """Mode (d,) above a start (d,), searched in units (d,) of about a standard deviation."""

    def objective(z: FloatArray) -> tuple[float, FloatArray]:
        value, gradient = density.log_prob_and_grad(start + unit * z)
        return -float(value), -unit * gradient

    from scipy import optimize  # slow to import, needed only here

    found = optimize.minimize(objective, np.zeros(len(start)), jac=True, method="BFGS")
    return start + unit * found.x


def require_mode(density: Density, mode: FloatArray) -> None:
    """Raise unless a sampler can start at a mode (d,).

    Raises
    ------
    InvalidInputError
        The mode lies outside the box, or the density is not finite there.
    """
    if density.box is not None and not density.inside(mode):
        bounded = zip(density.names, mode[: len(density.box)], strict=False)
        where = ", ".join(f"{name} {value:.4g}" for name, value in bounded)
        raise InvalidInputError(
            f"the box excludes the mode ({where}), so a sampler would only see a tail of the "
            "posterior. Widen the box, or say in a prior what you know."
        )
    with np.errstate(over="ignore", invalid="ignore"):
        height = float(density.log_prob(mode))
    if not np.isfinite(height):
        raise InvalidInputError(
            f"the log-density at the mode is {height}: nothing can start there. Check the "
            "reports for absurd values and the priors for their scale."
        )


def joint_covariance(
    density: Density, mode: FloatArray, known: FloatArray, step: FloatArray
) -> FloatArray:
    """Inverse curvature (d, d) at a mode (d,), of which the first block (p, p) is known.

    The rest is found by differences of the gradient over `step` (d - p,).

    Raises
    ------
    InvalidInputError
        The density is not curved downwards there.
    """
    p = len(known)
    precision = np.zeros((density.dim, density.dim))
    precision[:p, :p] = known
    ends = np.repeat(mode[None], 2 * len(step), axis=0)
    for k, h in enumerate(step):
        ends[2 * k, p + k] += h
        ends[2 * k + 1, p + k] -= h
    slopes = density.log_prob_and_grad(ends)[1]
    across = -(slopes[::2] - slopes[1::2]) / (2.0 * step[:, None])
    precision[p:, :p], precision[:p, p:] = across[:, :p], across[:, :p].T
    precision[p:, p:] = 0.5 * (across[:, p:] + across[:, p:].T)
    try:
        with np.errstate(invalid="ignore"):  # of a curvature upwards: said below
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
