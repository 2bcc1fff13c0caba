"""Radii and directions that the samplers of several laws draw."""

from __future__ import annotations

import numpy as np

from probreg.typing import FloatArray


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
