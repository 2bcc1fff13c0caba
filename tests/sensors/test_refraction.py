"""Refraction along the chord, against rays that are traced step by step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from probreg.sensors import refraction as module
from probreg.sensors.refraction import refraction
from tests.independent import rays


def towards(height, distance, own, radius=rays.RADIUS_M):
    """True elevation of a target of a height at a distance, over a sphere."""
    centre = radius + own
    return np.arcsin(((radius + height) ** 2 - centre**2 - distance**2) / (2.0 * centre * distance))


def traced(height, distance, own):
    elevation = towards(height, distance, own)
    bending, excess = rays.table(own).look_up(elevation, distance)
    return elevation, bending, excess


@pytest.mark.parametrize("own", [100.0, 600.0, 1500.0])
@pytest.mark.parametrize(
    ("farthest", "mrad", "metres"), [(100e3, 0.01, 0.1), (250e3, 0.07, 0.5)], ids=["100", "250"]
)
def test_against_traced_rays_to_a_target_at_ten_kilometres(own, farthest, mrad, metres):
    distance = np.arange(10e3, farthest + 1.0, 5e3)
    elevation, bending, excess = traced(10e3, distance, own)
    found = refraction(distance, elevation, own)
    assert 1e3 * np.abs(found.elevation - bending).max() < mrad
    assert np.abs(found.range - excess).max() < metres
    # what is left out matters: refraction itself is far larger
    assert 1e3 * bending.max() > 1.2
    assert excess.max() > 13.0


@pytest.mark.parametrize(("height", "farthest"), [(1e3, 100e3), (3e3, 150e3), (12e3, 250e3)])
def test_low_and_high_targets(height, farthest):
    distance = np.linspace(15e3, farthest, 40)
    elevation, bending, excess = traced(height, distance, 100.0)
    found = refraction(distance, elevation, 100.0)
    np.testing.assert_allclose(found.elevation, bending, rtol=0.017)
    np.testing.assert_allclose(found.range, excess, rtol=0.01)


@pytest.mark.parametrize(
    ("distance", "four_thirds", "rays_say"), [(100e3, 1.95, 1.44), (200e3, 3.92, 3.01)]
)
def test_an_earth_of_four_thirds_the_radius_misses(distance, four_thirds, rays_say):
    elevation, bending, _ = traced(10e3, np.array([distance]), 0.0)
    bent = towards(10e3, distance, 0.0, radius=4.0 / 3.0 * rays.RADIUS_M) - elevation
    assert 1e3 * bent[0] == pytest.approx(four_thirds, abs=0.01)
    assert 1e3 * bending[0] == pytest.approx(rays_say, abs=0.01)
    ours = refraction(np.array([distance]), elevation, 0.0).elevation
    assert np.abs(ours - bending)[0] < 0.05 * np.abs(bent - bending)[0]


def test_the_quadrature_is_the_integral():
    own, radius = 250.0, module.EARTH_RADIUS_M
    centre = radius + own
    for distance, elevation in ((5e3, 0.6), (80e3, 0.05), (250e3, 0.02), (250e3, 0.5)):

        def layer(x, elevation=elevation):
            far = np.sqrt(centre**2 + x**2 + 2.0 * centre * x * np.sin(elevation))
            dry = module.REFRACTIVITY * np.exp(-(far - radius) / module.SCALE_HEIGHT_M)
            return dry, centre * np.cos(elevation) / far

        def bend(x, distance=distance, layer=layer):
            dry, level = layer(x)
            return (distance - x) / distance * dry / module.SCALE_HEIGHT_M * level

        options = {"epsabs": 1e-13, "epsrel": 1e-12, "limit": 500, "points": [10e3]}
        found = refraction(np.array(distance), np.array(elevation), own)
        expected = quad(bend, 0.0, distance, **options)[0]
        assert found.elevation == pytest.approx(expected, abs=1e-9)
        excess = quad(lambda x, layer=layer: layer(x)[0], 0.0, distance, **options)[0]
        assert found.range == pytest.approx(excess, abs=1e-4)


def test_many_at_once_are_those_one_by_one_and_shapes_broadcast():
    rng = np.random.default_rng(0)
    distance, elevation = rng.uniform(1e3, 250e3, 20_000), rng.uniform(0.0, 0.7, 20_000)
    many = refraction(distance, elevation, 100.0)
    for k in (0, 8_191, 8_192, 19_999):
        one = refraction(distance[k], elevation[k], 100.0)
        assert (one.elevation, one.range) == (many.elevation[k], many.range[k])
    grid = refraction(distance[:6].reshape(2, 3), elevation[:3], np.array([[0.0], [900.0]]))
    assert grid.elevation.shape == grid.range.shape == (2, 3)
    high = refraction(distance[4], elevation[1], 900.0)
    assert grid.range[1, 1] == pytest.approx(high.range, rel=1e-14)


def test_refraction_is_proportional_to_refractivity_and_nothing_at_no_distance():
    distance, elevation = np.array([0.0, 100e3]), np.array([0.1, 0.05])
    plain, wet = refraction(distance, elevation, 0.0), refraction(distance, elevation, 0.0, 1.2)
    np.testing.assert_allclose(wet.elevation, 1.2 * plain.elevation, rtol=1e-14)
    np.testing.assert_allclose(wet.range, 1.2 * plain.range, rtol=1e-14)
    assert plain.elevation[0] == plain.range[0] == 0.0
