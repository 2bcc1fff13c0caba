"""Coefficients at knots against plain interpolation."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.problems.recording.knots import Knots

TIME = np.array([10.0, 20.0, 50.0, 60.0])
STAMP = np.array([0.0, 10.0, 17.0, 20.0, 35.0, 60.0, 99.0])


@pytest.fixture
def knots():
    return Knots(4, (1, 3), TIME)


def test_values_are_linear_between_knots_and_constant_beyond(knots):
    rng = np.random.default_rng(1)
    theta = rng.normal(size=(3, knots.size))
    found = knots.at(theta, STAMP)
    for draw, one in zip(theta, found, strict=True):
        for bias in range(4):
            own = draw[knots.places(bias)]
            wanted = np.interp(STAMP, TIME, own) if bias in (1, 3) else np.full(7, own[0])
            np.testing.assert_allclose(one[:, bias], wanted, rtol=1e-13)
            value = np.broadcast_to(knots.value(draw, bias, STAMP), 7)
            np.testing.assert_allclose(value, wanted, rtol=1e-13)


def test_every_coefficient_has_one_place(knots):
    places = np.concatenate([knots.places(bias) for bias in range(4)])
    np.testing.assert_array_equal(np.sort(places), np.arange(knots.size))
    assert knots.size == 2 + 2 * 4


def test_the_average_is_the_integral_over_the_knots(knots):
    theta = np.random.default_rng(2).normal(size=knots.size)
    fine = np.linspace(10.0, 60.0, 50_001)
    wanted = knots.at(theta, fine).mean(axis=0)
    np.testing.assert_allclose(knots.averages(theta), wanted, atol=1e-4)
    np.testing.assert_allclose(knots.average @ knots.constant, np.eye(4), atol=1e-15)


def test_constants_that_are_added_leave_the_others_in_order(knots):
    more, old = knots.with_more(2)
    theta = np.random.default_rng(3).normal(size=knots.size)
    larger = np.zeros(more.size)
    larger[old] = theta
    np.testing.assert_array_equal(more.at(larger, STAMP)[:, :4], knots.at(theta, STAMP))
    assert (more.at(larger, STAMP)[:, 4:] == 0.0).all()


def test_without_drift_coefficients_are_the_biases():
    knots, theta = Knots(3), np.array([1.0, 2.0, 3.0])
    assert knots.size == 3
    assert knots.averages(theta) is theta
    np.testing.assert_array_equal(knots.at(theta, STAMP), np.tile(theta, (7, 1)))


@pytest.mark.parametrize("time", [[1.0], [1.0, 1.0], [2.0, 1.0], [0.0, np.nan]])
def test_knots_that_cannot_be_are_refused(time):
    with pytest.raises(InvalidInputError):
        Knots(2, (0,), np.array(time))
