"""Angles, polar-to-Cartesian conversion, its sensitivity and its unbiased factors.

One internal convention: azimuth is counted from the x axis, counter-clockwise; elevation
upwards from the x-y plane. Metres and radians throughout.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.extending import register_jitable

from probreg.typing import FloatArray


@register_jitable
def wrap(angle: Any) -> Any:
    """Wrap to (-pi, pi]; the same code runs on arrays and in compiled loops."""
    return np.pi - np.mod(np.pi - angle, 2.0 * np.pi)


@register_jitable
def azimuth_and_gradient(dx: Any, dy: Any) -> tuple[Any, Any, Any]:
    """Azimuth of (dx, dy), and its derivatives by dx and dy; for arrays and compiled loops.

    The sign of the second derivative is not that printed in equation (3) of Zhang et al.,
    J. Air Force Engineering Univ. 15(4), 2014.
    """
    r2 = dx * dx + dy * dy
    return np.arctan2(dy, dx), -dy / r2, dx / r2


def wrap_angle(angle: FloatArray | float) -> FloatArray:
    """Wrap angles to the half-open interval (-pi, pi].

    Parameters
    ----------
    angle : array_like
        Angles in radians.

    Returns
    -------
    ndarray
        The same angles modulo 2 pi.
    """
    wrapped: FloatArray = wrap(np.asarray(angle, dtype=float))
    return wrapped


def azimuth_from_north(azimuth: FloatArray) -> FloatArray:
    """Swap between azimuth from y (north), clockwise, and azimuth from x, counter-clockwise.

    The map is its own inverse.
    """
    return wrap_angle(0.5 * np.pi - azimuth)


def polar_to_cartesian(polar: FloatArray) -> FloatArray:
    """Convert (range, azimuth) or (range, azimuth, elevation) to Cartesian coordinates.

    Parameters
    ----------
    polar : ndarray, shape (..., 2) or (..., 3)
        Range in metres, angles in radians.

    Returns
    -------
    ndarray, same shape
        x, y (and z) in metres.
    """
    polar = np.asarray(polar, dtype=float)
    rho, azimuth = polar[..., 0], polar[..., 1]
    if polar.shape[-1] == 2:
        return np.stack([rho * np.cos(azimuth), rho * np.sin(azimuth)], axis=-1)
    elevation = polar[..., 2]
    ground = rho * np.cos(elevation)
    return np.stack(
        [ground * np.cos(azimuth), ground * np.sin(azimuth), rho * np.sin(elevation)], axis=-1
    )


def cartesian_to_polar(position: FloatArray) -> FloatArray:
    """Invert `polar_to_cartesian`; shapes and units as there."""
    position = np.asarray(position, dtype=float)
    azimuth = np.arctan2(position[..., 1], position[..., 0])
    ground = np.hypot(position[..., 0], position[..., 1])
    if position.shape[-1] == 2:
        return np.stack([ground, azimuth], axis=-1)
    height = position[..., 2]
    return np.stack([np.hypot(ground, height), azimuth, np.arctan2(height, ground)], axis=-1)


def polar_jacobian(position: FloatArray) -> FloatArray:
    """Derivative of the Cartesian position with respect to range, azimuth (and elevation).

    Evaluated from the Cartesian position itself, so that no trigonometric function is called.

    Parameters
    ----------
    position : ndarray, shape (..., d)
        Position relative to the sensor, d = 2 or 3, metres.

    Returns
    -------
    ndarray, shape (..., d, d)
        Columns are d/d range, d/d azimuth (and d/d elevation).

    References
    ----------
    Guo et al., Control and Decision (2017), equation (4).
    """
    position = np.asarray(position, dtype=float)
    dim = position.shape[-1]
    ground = np.hypot(position[..., 0], position[..., 1])
    jacobian = np.zeros((*position.shape, dim))
    rho = ground if dim == 2 else np.hypot(ground, position[..., 2])
    jacobian[..., :, 0] = position / rho[..., None]
    jacobian[..., 0, 1] = -position[..., 1]
    jacobian[..., 1, 1] = position[..., 0]
    if dim == 3:
        slope = position[..., 2] / ground
        jacobian[..., 0, 2] = -position[..., 0] * slope
        jacobian[..., 1, 2] = -position[..., 1] * slope
        jacobian[..., 2, 2] = ground
    return jacobian


def unbiased_factors(sigma_azimuth: float, sigma_elevation: float | None = None) -> FloatArray:
    """Multipliers that make the mean of a converted noisy report equal the true position.

    For Gaussian angle errors E[cos(a + e)] = exp(-s^2 / 2) cos a, so the plain conversion
    shrinks towards the sensor; the factors undo that.

    Parameters
    ----------
    sigma_azimuth, sigma_elevation : float
        Standard deviations in radians; no elevation means a 2-D sensor.

    Returns
    -------
    ndarray, shape (2,) or (3,)
        Factors of x, y (and z).
    """
    if sigma_elevation is None:
        return np.full(2, np.exp(0.5 * sigma_azimuth**2))
    level = np.exp(0.5 * (sigma_azimuth**2 + sigma_elevation**2))
    return np.array([level, level, np.exp(0.5 * sigma_elevation**2)])
