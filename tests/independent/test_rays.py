"""The tracer of rays against Bouguer's invariant and against another equation and integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.independent import rays

APPARENT = np.deg2rad([-0.2, 0.3, 1.0, 3.0, 10.0, 45.0])


def refractivity(height):
    return rays.REFRACTIVITY * np.exp(-height / rays.SCALE_HEIGHT_M)


def test_bouguer_holds_along_every_ray():
    traced = rays.trace(APPARENT, 120.0, 500.0, 600)
    index = 1.0 + refractivity(traced.height)
    invariant = index * (rays.RADIUS_M + traced.height) * np.cos(traced.angle)
    np.testing.assert_allclose(invariant / invariant[0], 1.0, atol=1e-12)


def test_rays_against_the_eikonal_equation_in_cartesian_coordinates():
    # d/ds (n dr/ds) = grad n, in the plane of the ray, by an integrator of order eight
    start, length = rays.RADIUS_M + 120.0, 250e3
    traced = rays.trace(APPARENT, 120.0, 500.0, 500)

    def slopes(_, state):
        place, momentum = np.array([state[0], start + state[1]]), state[2:4]
        radius = np.hypot(*place)
        dry = refractivity(radius - rays.RADIUS_M)
        gradient = -dry / rays.SCALE_HEIGHT_M * place / radius
        return [*(momentum / (1.0 + dry)), *gradient, dry]

    for k, angle in enumerate(APPARENT):
        index = 1.0 + refractivity(120.0)
        state = [0.0, 0.0, index * np.cos(angle), index * np.sin(angle), 0.0]
        options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-9, "max_step": 5e3}
        end = solve_ivp(slopes, (0.0, length), state, **options).y[:, -1]
        assert np.arctan2(end[1], end[0]) == pytest.approx(traced.elevation[-1, k], abs=1e-9)
        chord = np.hypot(end[0], end[1])
        assert chord == pytest.approx(traced.chord[-1, k], abs=1e-4)
        assert end[4] + length - chord == pytest.approx(traced.excess[-1, k], abs=1e-4)


def test_the_table_gives_back_rays_between_its_own():
    rng = np.random.default_rng(0)
    apparent = np.deg2rad(rng.uniform(0.0, 40.0, 200))
    traced = rays.trace(apparent, 120.0, 777.0, 500)
    for row in (20, 130, 330, 500):
        elevation, chord = traced.elevation[row], traced.chord[row]
        bending, excess = rays.table(120.0).look_up(elevation, chord)
        np.testing.assert_allclose(bending, apparent - elevation, atol=2e-7)
        np.testing.assert_allclose(excess, traced.excess[row], atol=3e-3)


def test_without_refractivity_rays_are_straight():
    traced = rays.trace(APPARENT, 0.0, 500.0, 600, scale=0.0)
    np.testing.assert_allclose(
        traced.elevation[1:], np.broadcast_to(APPARENT, (600, 6)), atol=1e-11
    )
    np.testing.assert_allclose(traced.excess, 0.0, atol=1e-6)


def test_what_the_table_does_not_hold_is_refused():
    with pytest.raises(ValueError, match="beyond the table"):
        rays.table(120.0).look_up(np.array([0.1]), np.array([2e6]))
