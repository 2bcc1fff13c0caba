from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from probreg.sensors import geometry

ANGLES = st.floats(-50.0, 50.0)


@given(ANGLES)
def test_wrapped_angles_are_in_the_interval_and_equal_modulo_a_turn(angle):
    wrapped = float(geometry.wrap_angle(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.cos(wrapped) == pytest.approx(np.cos(angle), abs=1e-12)
    assert np.sin(wrapped) == pytest.approx(np.sin(angle), abs=1e-12)


def test_minus_pi_wraps_to_pi():
    assert geometry.wrap_angle(-np.pi) == np.pi
    assert geometry.wrap_angle(np.pi) == np.pi


@given(st.floats(1.0, 1e5), st.floats(-3.1, 3.1), st.floats(-1.5, 1.5))
def test_conversion_round_trip(rho, azimuth, elevation):
    for polar in (np.array([rho, azimuth]), np.array([rho, azimuth, elevation])):
        back = geometry.cartesian_to_polar(geometry.polar_to_cartesian(polar))
        np.testing.assert_allclose(back, polar, rtol=1e-9, atol=1e-9)


def test_north_is_y_and_east_is_x():
    # reported from north, clockwise: 0 is +y, 90 degrees is +x
    for degrees, expected in ((0.0, (0.0, 1.0)), (90.0, (1.0, 0.0)), (180.0, (0.0, -1.0))):
        azimuth = geometry.azimuth_from_north(np.deg2rad(degrees))
        got = geometry.polar_to_cartesian(np.array([1.0, azimuth]))
        np.testing.assert_allclose(got, expected, atol=1e-15)


@given(ANGLES)
def test_azimuth_from_north_is_its_own_inverse(angle):
    back = geometry.azimuth_from_north(geometry.azimuth_from_north(angle))
    assert float(np.cos(back - angle)) == pytest.approx(1.0)


@pytest.mark.parametrize("dim", [2, 3])
def test_jacobian_against_complex_steps(dim):
    rng = np.random.default_rng(0)
    polar = np.column_stack(
        [rng.uniform(1e3, 3e4, 20), rng.uniform(-3, 3, 20), rng.uniform(-1, 1, 20)]
    )
    polar = polar[:, :dim]

    def convert(z):
        ground = z[0] * (np.cos(z[2]) if dim == 3 else 1.0)
        flat = [ground * np.cos(z[1]), ground * np.sin(z[1])]
        return np.array(flat + ([z[0] * np.sin(z[2])] if dim == 3 else []))

    for z in polar:
        steps = [convert(z + 1e-30j * e).imag / 1e-30 for e in np.eye(dim)]
        got = geometry.polar_jacobian(geometry.polar_to_cartesian(z))
        np.testing.assert_allclose(got, np.array(steps).T, rtol=1e-10, atol=1e-8)


@pytest.mark.parametrize("dim", [2, 3])
def test_unbiased_factors_make_the_mean_right(dim):
    # 3 components at 5 standard errors: false alarm rate 2e-6; and the plain mean must fail
    rng = np.random.default_rng(1)
    sigmas, truth = np.array([10.0, 0.1, 0.08])[:dim], np.array([1000.0, 0.7, 0.4])[:dim]
    noisy = truth + sigmas * rng.normal(size=(400_000, dim))
    plain = geometry.polar_to_cartesian(noisy)
    fixed = plain * geometry.unbiased_factors(*sigmas[1:])
    position = geometry.polar_to_cartesian(truth)
    error = fixed.std(axis=0) / np.sqrt(len(noisy))
    assert (np.abs(fixed.mean(axis=0) - position) < 5.0 * error).all()
    assert (np.abs(plain.mean(axis=0) - position)[:2] > 5.0 * error[:2]).all()
