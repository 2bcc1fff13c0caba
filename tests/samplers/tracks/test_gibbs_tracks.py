"""The Gibbs sampler of tracks leaves the prior alone, is calibrated, and agrees with the mode."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from probreg.diagnostics.sbc import Ranks
from probreg.errors import InvalidInputError
from probreg.noise import StudentT
from probreg.posterior.tracks import fit_tracks, solve
from probreg.posterior.tracks.accelerations import LIVELY_TARGETS, USUAL_TARGETS
from probreg.samplers.tracks import GibbsTracks, _mode_check, check_mode
from probreg.samplers.tracks.gibbs_tracks import _sweep
from tests.posterior.traffic_tracks import draw, model_of
from tests.samplers.tracks.prior_tracks import ABOUT, draw_all, point_at


def after_sweeps(seed, about, replicates, sweeps=4, blow=1.0):
    """Unknowns after some sweeps from the truth, each replicate with data of its own.

    The truth is a draw from the posterior of its data: sweeps that are right leave every unknown
    distributed as in the prior. `blow` widens the sensors that the sampler believes in.
    """
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(replicates):
        model, truth = draw_all(rng, about)
        if blow != 1.0:
            wider = tuple(replace(m, sigmas=blow * m.sigmas) for m in model.reports.models)
            model = replace(model, reports=replace(model.reports, models=wider))
        point = point_at(model, truth)
        for _ in range(sweeps):
            last = _sweep(model, point, 1.0, rng)
            point = last.point
        law = point.laws[1]
        shape = law.nu if isinstance(law, StudentT) else law.rate
        scale = law.scale if isinstance(law, StudentT) else law.core_scale
        own = [*last.theta, point.q, shape, scale, point.wrong[2], point.constant_sd[0]]
        own.append(point.shares[2])
        found.append(own)
    return np.array(found).T


def p_values(found, about):
    """Of the prior of every unknown, by Kolmogorov and Smirnov."""
    normal = stats.norm(0.0, 100.0)
    nu = stats.gamma(2.0, scale=10.0)
    low, high = nu.cdf([0.5, 100.0])
    shape = (
        (lambda x: (nu.cdf(x) - low) / (high - low))
        if isinstance(about, StudentT)
        else stats.beta(1.0, 9.0).cdf
    )
    priors = [
        *(normal.cdf,) * 4,
        lambda x: stats.norm.cdf(np.log(x / 4.0)),
        shape,
        lambda x: stats.chi2(4).sf(4.0 / x**2),
        stats.beta(1.0, 9.0).cdf,
        lambda x: stats.chi2(2).sf(2.0 * 60.0**2 / x**2),
        stats.beta(LIVELY_TARGETS / 2, USUAL_TARGETS + LIVELY_TARGETS / 2).cdf,
    ]
    return np.array([stats.kstest(x, cdf).pvalue for x, cdf in zip(found, priors, strict=True)])


@pytest.mark.parametrize("about", [ABOUT, StudentT(4.0)], ids=["contaminated", "student"])
def test_sweeps_leave_the_prior_alone(about):
    p = p_values(after_sweeps(1, about, 250), about)
    # one false alarm in a thousand seeds
    assert p.min() > 1e-3 / len(p)


def test_a_sampler_that_believes_in_other_sensors_is_found_out():
    p = p_values(after_sweeps(1, ABOUT, 250, sweeps=12, blow=1.5), ABOUT)
    assert p.min() < 1e-4


def ranks_of(kept, truth, thin):
    """Of the truth among every `thin`-th draw."""
    rows = slice(thin - 1, None, thin)
    laws = [laws[0] for laws in kept.laws[0]]
    series = [
        *kept.theta[0].T,
        kept.acceleration[0],
        np.array([law.core_scale for law in laws]),
        np.array([law.rate for law in laws]),
        kept.wrong_share[0, :, 1],
        kept.constant_sd[0, :, 0],
    ]
    law = truth.laws[0]
    true = [*truth.theta, truth.q, law.core_scale, law.rate, truth.wrong[1], truth.constant_sd[0]]
    return [int((x[rows] < value).sum()) for x, value in zip(series, true, strict=True)]


@pytest.mark.slow
def test_draws_are_calibrated():
    rng, thin, draws = np.random.default_rng(2), 5, 60
    ranks = []
    for _ in range(200):
        model, truth = draw_all(rng)
        kept = GibbsTracks(warmup=60).sample(fit_tracks(model, offers=0), draws * thin, 1, rng)
        ranks.append(ranks_of(kept, truth, thin))
    names = ("x1", "y1", "x2", "y2", "q", "core", "rate", "wrong", "constant")
    Ranks(np.array(ranks), draws, names).require(1e-3)


@pytest.fixture(scope="module")
def traffic():
    recording, setup, truth = draw(1, wrong_share=0.2, outlier_share=0.05)
    model, _ = model_of(recording, setup, wrong_share=0.05)
    return recording, setup, truth, fit_tracks(model)


def test_the_mode_agrees_with_chains_under_contaminated_noise(traffic):
    checked = check_mode(traffic[3], np.random.default_rng(3), 200)
    assert checked.agrees
    np.testing.assert_allclose(checked.sd_ratio, 1.0, atol=0.03)
    np.testing.assert_allclose(checked.shift, 0.0, atol=0.05)


def test_the_mode_is_too_narrow_under_student_noise_and_the_check_says_so(traffic):
    recording, setup, *_ = traffic
    model, _ = model_of(recording, setup, StudentT(4.0), wrong_share=0.05)
    checked = check_mode(fit_tracks(model), np.random.default_rng(4), 60)
    assert not checked.agrees
    assert checked.sd_ratio.max() < 0.95


def test_many_reports_are_checked_on_some(traffic, monkeypatch):
    monkeypatch.setattr(_mode_check, "MANY_REPORTS", 3000)
    monkeypatch.setattr(_mode_check, "SOME_REPORTS", 1500)
    checked = check_mode(traffic[3], np.random.default_rng(5), 20)
    assert len(checked.fit.model.reports) < 2000
    assert checked.draws.theta.shape == (1, 20, 6)


def test_probabilities_of_reports_are_those_of_the_mode(traffic):
    """Two ways to the same numbers: leave-one-out densities and shares of draws."""
    fit = traffic[3]
    draws = GibbsTracks().sample(fit, 200, 1, np.random.default_rng(6))
    for one, other in ((draws.wrong, fit.wrong), (draws.outlier, fit.outlier)):
        # neighbours in sweeps are alike: some fifty effective draws of each report
        sd = np.sqrt((other * (1.0 - other) + 1e-3) / 50.0)
        assert np.abs((one - other) / sd).mean() < 1.0
    moved = np.linalg.norm((draws.mean_state - fit.mean)[:, :2], axis=1)
    spread = np.sqrt(np.einsum("naa->n", fit.state_covariance()[:, :2, :2]))
    assert np.median(moved / spread) < 0.2


def test_moments_add_up_what_is_within_and_between(traffic):
    fit = traffic[3]
    draws = GibbsTracks(warmup=2).sample(fit, 30, 2, np.random.default_rng(7))
    again = solve(fit.model, fit.point)
    np.testing.assert_allclose(again.theta, fit.theta)
    between = np.cov(draws.conditional_mean.reshape(-1, 6).T)
    within = draws.conditional_covariance.mean(axis=(0, 1))
    np.testing.assert_allclose(draws.covariance, within + between, rtol=1e-9)
    np.testing.assert_allclose(draws.mean, draws.conditional_mean.mean(axis=(0, 1)))


def test_a_known_acceleration_stays():
    recording, setup, _ = draw(2, reports=600)
    model, _ = model_of(recording, setup, acceleration=2.0, acceleration_log_sd=0.0)
    fit = fit_tracks(model)
    draws = GibbsTracks(warmup=1).sample(fit, 3, 1, np.random.default_rng(8))
    assert fit.point.q == 2.0
    assert (draws.acceleration == 2.0).all()


def test_runs_of_no_draws_or_no_generator_are_refused(traffic):
    with pytest.raises(InvalidInputError, match="num_draws"):
        GibbsTracks().sample(traffic[3], 0, 1, np.random.default_rng(0))
    with pytest.raises(InvalidInputError, match="rng"):
        GibbsTracks().sample(traffic[3], 1, 1, 0)


def test_the_error_of_a_shift_is_the_spread_of_shifts():
    rng = np.random.default_rng(9)
    model, _ = draw_all(rng)
    fit = fit_tracks(model, offers=0)
    checks = [check_mode(fit, rng, 60) for _ in range(40)]
    spread = np.std([c.shift for c in checks], axis=0)
    claimed = np.sqrt(np.mean([c.shift_error**2 for c in checks], axis=0))
    # forty chains know a spread to a ninth; sweeps remember a little more than the last
    assert (spread / claimed).max() < 2.0
    assert (spread / claimed).min() > 0.6
