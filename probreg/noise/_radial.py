"""Radii: integrals over them, and radii and directions that samplers of several laws draw."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.special import gammaln

from probreg.typing import FloatArray


def radial_integral(
    log_kernel: Callable[[FloatArray], FloatArray],
    function: Callable[[FloatArray], FloatArray],
    m: int,
    corners: tuple[float, ...],
) -> float:
    """Integral over R^m of function(|v|^2) exp(log_kernel(|v|^2)), split at the corners."""
    from scipy.integrate import quad  # slow to import, seldom needed

    sphere = np.log(2.0) + 0.5 * m * np.log(np.pi) - gammaln(0.5 * m)

    def integrand(radius: float) -> float:
        d2 = np.array([radius**2])
        density = float(np.exp(sphere + log_kernel(d2)[0]) * function(d2)[0])
        return density * radius ** (m - 1)

    edges = [0.0, *sorted(corners), np.inf]
    return sum(
        quad(integrand, a, b, epsabs=0.0, epsrel=1e-10, limit=200)[0] for a, b in pairwise(edges)
    )


def truncated_chi(rng: np.random.Generator, n: int, m: int, upper: float) -> FloatArray:
    """Draw radii of m-dimensional standard normal vectors shorter than `upper`."""
    from scipy.special import gammainc, gammaincinv

    mass = gammainc(0.5 * m, 0.5 * upper**2)
    return np.sqrt(2.0 * gammaincinv(0.5 * m, mass * rng.random(n)))


def truncated_gamma(rng: np.random.Generator, n: int, shape: float, lower: float) -> FloatArray:
    """Draw unit-rate Gamma(shape) numbers above `lower`."""
    from scipy.special import gammaincc, gammainccinv

    return gammainccinv(shape, gammaincc(shape, lower) * rng.random(n))


def on_sphere(rng: np.random.Generator, radius: FloatArray, m: int) -> FloatArray:
    """Give each radius a uniformly random direction in m dimensions, shape (n, m)."""
    direction = rng.standard_normal((len(radius), m))
    return radius[:, None] * direction / np.linalg.norm(direction, axis=1, keepdims=True)
