"""Drifting coefficients against dense Gaussian algebra and brute-force integration."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from probreg.errors import InvalidInputError
from probreg.posterior.tracks.drift_draws import draw_drift
from probreg.posterior.tracks.drifting import (
    DriftPrior,
    Evidence,
    coefficients,
    fit_spreads,
    profile,
)
from probreg.prior import GaussianPrior
from probreg.problems.recording.knots import Knots
from probreg.sensors.drifts import known_drifts

TIME = np.array([0.0, 60.0, 150.0, 200.0, 400.0, 460.0])
KNOTS = Knots(3, (0, 2), TIME)
LEVEL = GaussianPrior(np.array([1.0, -2.0, 0.5]), np.diag([4.0, 9.0, 2.0]))


def prior_of(*kinds):
    return DriftPrior(LEVEL, KNOTS, tuple(known_drifts()[k] for k in kinds), np.array([2.0, 3.0]))


def made(prior, seed, rows=40, noise=0.5):
    """Reports y = H theta + noise, and what they say counted from some theta."""
    rng = np.random.default_rng(seed)
    H = rng.normal(size=(rows, KNOTS.size))
    y = H @ prior.mean + rng.normal(0.0, 3.0, rows)
    start = rng.normal(size=KNOTS.size)
    off = y - H @ start
    ll = -0.5 * (rows * np.log(2.0 * np.pi * noise**2) + off @ off / noise**2)
    return H, y, Evidence.at(prior, H.T @ H / noise**2, H.T @ off / noise**2, start, ll)


def covariance_of(kinds, spread):
    """Of all coefficients, written out from the processes' definitions."""
    s, t = np.meshgrid(TIME, TIME, indexing="ij")
    shape = {
        "walk": np.minimum(s, t) / 3600.0,
        "ou": np.exp(-np.abs(s - t) / 600.0),
        "steps": np.minimum(
            *np.meshgrid(*[np.concatenate([[0.0], np.cumsum(np.diff(TIME) ** 2)])] * 2)
        ) / 3600.0**2,
    }  # fmt: skip
    C = np.zeros((KNOTS.size, KNOTS.size))
    C[0, 0] = 9.0
    for j, (bias, kind) in enumerate(zip((0, 2), kinds, strict=True)):
        own = KNOTS.places(bias)
        C[np.ix_(own, own)] = LEVEL.covariance[bias, bias] + spread[j] ** 2 * shape[kind]
    return C


@pytest.mark.parametrize("spread", [(2.0, 5.0), (0.0, 1.0), (0.0, 0.0)])
@pytest.mark.parametrize("kinds", [("walk", "ou"), ("steps", "walk"), ("ou", "steps")])
def test_coefficients_given_spreads_are_those_of_dense_algebra(kinds, spread):
    prior = prior_of(*kinds)
    H, y, evidence = made(prior, 1)
    found = coefficients(prior, evidence, prior.usual._replace(spread=np.array(spread)))
    C = covariance_of(kinds, spread)
    S = H @ C @ H.T + 0.25 * np.eye(len(y))
    gain = C @ H.T @ np.linalg.inv(S)
    np.testing.assert_allclose(found.mean, prior.mean + gain @ (y - H @ prior.mean), rtol=1e-8)
    np.testing.assert_allclose(found.covariance, C - gain @ H @ C, rtol=1e-7, atol=1e-9)
    wanted = stats.multivariate_normal(H @ prior.mean, S).logpdf(y)
    assert found.log_marginal == pytest.approx(wanted, rel=1e-9)


def test_a_profile_is_the_marginal_likelihood_at_every_spread():
    prior = prior_of("walk", "ou")
    _, _, evidence = made(prior, 2)
    at = prior.usual
    found = profile(prior, evidence, at, 0)
    heights = [
        coefficients(prior, evidence, at._replace(spread=np.array([s, at.spread[1]]))).log_marginal
        for s in found.spread[::8]
    ]
    np.testing.assert_allclose(found.log_density[::8], np.array(heights) - heights[0], atol=1e-8)
    assert np.exp(found.log_posterior).sum() == pytest.approx(1.0)


def test_half_of_the_prior_is_on_constant_and_its_median_beyond_is_the_scale():
    prior = prior_of("walk", "ou")
    mute = Evidence(np.zeros((KNOTS.size, KNOTS.size)), np.zeros(KNOTS.size), 0.0)
    found = profile(prior, mute, prior.usual, 1)
    assert found.constant == pytest.approx(0.5)
    share = np.exp(found.log_posterior)
    assert share[1:][found.spread[1:] < 3.0].sum() == pytest.approx(0.25, abs=0.01)


def test_draws_are_those_of_brute_force_integration_over_the_spreads():
    """Two spreads on a coarse product grid; false alarms below 1e-4."""
    prior = prior_of("walk", "ou")
    _, _, evidence = made(prior, 3, rows=12, noise=1.0)
    first, second = prior.grid(0), prior.grid(1)
    weight, means, squares = [], [], []
    for a, log_a in zip(*first, strict=True):
        for b, log_b in zip(*second, strict=True):
            one = coefficients(prior, evidence, prior.usual._replace(spread=np.array([a, b])))
            weight.append(one.log_marginal + log_a + log_b)
            means.append(one.mean)
            squares.append(np.diag(one.covariance) + one.mean**2)
    share = np.exp(np.array(weight) - np.max(weight))
    share /= share.sum()
    mean = share @ np.array(means)
    sd = np.sqrt(share @ np.array(squares) - mean**2)
    near = fit_spreads(prior, evidence)
    rng = np.random.default_rng(1)
    parts = [draw_drift(prior, evidence, near, 2_000, rng) for _ in range(10)]
    theta = np.concatenate([part.theta for part in parts])
    error = np.std([part.theta.mean(axis=0) for part in parts], axis=0) / np.sqrt(10.0)
    assert (np.abs(theta.mean(axis=0) - mean) < 5.0 * error + 0.01 * sd).all()
    np.testing.assert_allclose(theta.std(axis=0), sd, rtol=0.06)
    constant = np.mean([part.constant for part in parts], axis=0)
    grid = share.reshape(len(first[0]), len(second[0]))
    wanted = grid[0].sum(), grid[:, 0].sum()
    np.testing.assert_allclose(constant, wanted, atol=0.03)


def test_a_step_stands_where_it_was_and_a_walk_smears_it():
    time = np.arange(0.0, 1201.0, 20.0)
    knots = Knots(1, (0,), time)
    level = GaussianPrior.from_sd(np.array([1.0]))
    truth = np.where(time >= 610.0, 0.1, 0.0)
    rng = np.random.default_rng(4)
    J = np.eye(len(time)) / 0.01**2
    y = truth + rng.normal(0.0, 0.01, len(time))
    error = {}
    for kind in ("steps", "walk"):
        prior = DriftPrior(level, knots, (known_drifts()[kind],), np.array([0.1]))
        evidence = Evidence.at(prior, J, J @ y, np.zeros(len(time)), 0.0)
        found = draw_drift(prior, evidence, fit_spreads(prior, evidence), 2_000, rng)
        error[kind] = np.sqrt(np.mean((found.theta.mean(axis=0) - truth) ** 2))
        if kind == "steps":
            jump = np.abs(np.diff(found.theta, axis=1)).argmax(axis=1)
            assert (time[jump] == 600.0).mean() > 0.95
        assert found.constant[0] < 1e-6
    assert error["steps"] < 0.6 * error["walk"]


def test_what_does_not_fit_is_refused():
    walk = known_drifts()["walk"]
    for kinds, scale in [((walk,), [1.0, 2.0]), ((walk, walk), [1.0]), ((walk, walk), [1.0, 0.0])]:
        with pytest.raises(InvalidInputError, match="drift"):
            DriftPrior(LEVEL, KNOTS, kinds, np.array(scale))
