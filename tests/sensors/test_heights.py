"""Barometric heights: steps found in them, and offset and share as one number at a height."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.sensors.heights import error_at, quantisation_step, quantisation_variance

FOOT = 0.3048


def heights(step_ft, n=400, seed=0):
    true = np.random.default_rng(seed).uniform(1e3, 12e3, n)
    return true, FOOT * step_ft * np.rint(true / (FOOT * step_ft))


@pytest.mark.parametrize("step", [25.0, 100.0])
@pytest.mark.parametrize("decimals", [0, 6])
def test_steps_are_found_even_in_whole_metres(step, decimals):
    _, reported = heights(step)
    assert quantisation_step(np.round(reported, decimals)) == pytest.approx(FOOT * step)


def test_no_step_where_there_is_none_or_too_few_to_tell():
    true, reported = heights(100.0)
    assert quantisation_step(true) == 0.0
    assert quantisation_step(reported[:10]) == 0.0
    # a single height between the steps is enough to say no
    assert quantisation_step(np.append(reported, FOOT * 1060.0)) == 0.0


@pytest.mark.parametrize("step", [25.0, 100.0])
def test_variance_of_rounding_of_climbs(step):
    # the variance of a uniform error has relative error sqrt(0.8 / n); 5 of them: 6e-7
    true, reported = heights(step, n=100_000)
    expected = np.var(reported - true)
    assert quantisation_variance(FOOT * step) == pytest.approx(expected, rel=5.0 * np.sqrt(0.8e-5))


def test_offset_and_share_at_a_height_against_draws():
    mean, covariance = np.array([40.0, -0.01]), np.array([[2500.0, -0.24], [-0.24, 2.5e-5]])
    draws = np.random.default_rng(1).multivariate_normal(mean, covariance, 200_000)
    error = draws[:, 0] + 9e3 * draws[:, 1]
    found, sd = error_at(mean, covariance, 9e3)
    assert found == pytest.approx(error.mean(), abs=5.0 * sd / np.sqrt(len(draws)))
    assert sd == pytest.approx(error.std(), rel=5.0 / np.sqrt(2.0 * len(draws)))
    assert sd < 0.6 * np.sqrt(covariance[0, 0])


def test_what_is_no_covariance_is_refused():
    with pytest.raises(InvalidInputError, match="variance of the error at 9000 m is -"):
        error_at(np.zeros(2), np.array([[1.0, -1.0], [-1.0, 1e-5]]), 9e3)
    with pytest.raises(InvalidInputError, match=r"heights\[1\] is nan"):
        quantisation_step(np.array([1.0, np.nan]))
