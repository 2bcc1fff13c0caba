"""Every sampler found in probreg.samplers."""

from __future__ import annotations

import numpy as np
import pytest

import probreg.samplers
from probreg import BearingProblem, GaussianPrior, Posterior, ReportProblem, UnobservableError
from probreg.discovery import public_classes
from probreg.errors import ImproperLawError, InvalidInputError
from probreg.noise import Gaussian, HardReject, StudentT
from probreg.prior import NoiseParameter
from probreg.samplers import Exact, Nuts
from tests.conftest import (
    EMITTER,
    PAIR_BIAS,
    linear_problem,
    passive_reports,
    polar_reports,
    radar_pair,
)
from tests.judge import limit, z_scores

SAMPLERS = [cls() for cls in public_classes(probreg.samplers).values()]
NAMED = {"argvalues": SAMPLERS, "ids": lambda s: type(s).__name__}
PRIOR = GaussianPrior.from_sd(np.full(4, 3.0), np.array([0.5, 0.0, -0.5, 1.0]))


def rng(seed=3):
    return np.random.default_rng(seed)


def gaussian_posterior(n=60):
    return Posterior(linear_problem(1, n=n).problem, Gaussian(), PRIOR)


def size(sampler):
    return (400, 2) if isinstance(sampler, Nuts) else (500, 16)


def test_discovery_finds_the_samplers():
    expected = {"Exact", "Gibbs", "Importance", "MetropolisHastings", "Nuts"}
    assert expected <= set(public_classes(probreg.samplers))


@pytest.mark.parametrize("sampler", **NAMED)
def test_gaussian_posterior_is_the_closed_form(sampler):
    # 8 scores a sampler, family-wise false-alarm rate 1e-4 each
    posterior = gaussian_posterior()
    problem = posterior.problem
    weight = np.linalg.inv(problem.R)
    precision = np.einsum("nmp,nmk,nkq->pq", problem.B, weight, problem.B) + np.eye(4) / 9.0
    right = np.einsum("nmp,nmk,nk->p", problem.B, weight, problem.y) + PRIOR.mean / 9.0
    covariance = np.linalg.inv(precision)
    draws = sampler.sample(posterior, *size(sampler), rng())
    scores = z_scores(draws, covariance @ right, np.diag(covariance))
    assert np.abs(scores).max() < limit(scores, 1e-4)
    assert draws.gamma == 1.0
    assert not draws.warnings


@pytest.mark.parametrize("sampler", **NAMED)
def test_same_seed_same_draws(sampler):
    posterior = gaussian_posterior()
    one, two, other = (sampler.sample(posterior, 10, 2, rng(s)) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.theta, two.theta)
    assert (one.theta != other.theta).any()
    assert one.theta.shape == (2, 10, 4)
    assert all(value.shape == (2, 10) for value in one.stats.values())


@pytest.mark.parametrize("sampler", **NAMED)
def test_log_prob_of_the_draws_is_theirs(sampler):
    posterior = gaussian_posterior()
    draws = sampler.sample(posterior, 6, 3, rng())
    expected = posterior.log_prob(posterior.free(draws.theta))
    np.testing.assert_allclose(draws.stats["log_prob"], expected, rtol=1e-9)


@pytest.mark.parametrize("sampler", **NAMED)
def test_it_leaves_global_state_alone(sampler):
    import random

    import torch

    posterior = gaussian_posterior()
    before = torch.get_rng_state(), np.random.get_state()[1].copy(), random.getstate()  # noqa: NPY002
    threads, dtype = torch.get_num_threads(), torch.get_default_dtype()
    sampler.sample(posterior, 5, 2, rng())
    assert torch.equal(torch.get_rng_state(), before[0])
    np.testing.assert_array_equal(np.random.get_state()[1], before[1])  # noqa: NPY002
    assert random.getstate() == before[2]
    assert (torch.get_num_threads(), torch.get_default_dtype()) == (threads, dtype)


@pytest.mark.parametrize("sampler", **NAMED)
def test_what_cannot_be_sampled_is_refused(sampler):
    problem = linear_problem(1).problem
    with pytest.raises(ImproperLawError, match="no posterior to sample"):
        sampler.sample(Posterior(problem, HardReject(3.0), PRIOR), 10, 2, rng())
    with pytest.raises(InvalidInputError, match="num_draws"):
        sampler.sample(gaussian_posterior(), 0, 2, rng())
    with pytest.raises(InvalidInputError, match="num_chains"):
        sampler.sample(gaussian_posterior(), 10, 1.5, rng())
    with pytest.raises(InvalidInputError, match=r"Generator: default_rng\(seed\)"):
        sampler.sample(gaussian_posterior(), 10, 2, 7)
    with pytest.raises(InvalidInputError, match="takes a Posterior"):
        sampler.sample(problem, 10, 2, rng())


@pytest.mark.parametrize("sampler", **NAMED)
def test_an_undetermined_direction_needs_a_prior(sampler):
    first, second = radar_pair()
    same = type(first)(
        first.position, second.sigma_range, second.sigma_azimuth, second.sigma_elevation, "j"
    )
    problem = ReportProblem(polar_reports((first, same), PAIR_BIAS, seed=8))
    with pytest.raises(UnobservableError, match=r"i\.range \+ j\.range"):
        Posterior(problem, Gaussian())
    prior = GaussianPrior.default(problem)
    draws = sampler.sample(Posterior(problem, Gaussian(), prior), 300, 4, rng())
    # only the prior holds the sum of the ranges: each keeps 1 / sqrt(2) of its prior sd
    assert draws.sd[0] == pytest.approx(100.0 / np.sqrt(2.0), rel=0.15)
    assert "i.range: normal 0 +- 100 m" in str(draws)


@pytest.mark.parametrize("sampler", **NAMED)
def test_a_box_is_kept_or_refused(sampler):
    box = np.array([[-np.inf, np.inf]] * 4)
    mode = gaussian_posterior().laplace.mean
    sd = np.sqrt(np.diag(gaussian_posterior().laplace.covariance))
    box[0] = mode[0] - 0.3 * sd[0], mode[0] + 2.0 * sd[0]
    posterior = Posterior(linear_problem(1).problem, Gaussian(), PRIOR, box=box)
    if isinstance(sampler, Exact | Nuts):
        with pytest.raises(InvalidInputError, match="box"):
            sampler.sample(posterior, 10, 2, rng())
        return
    draws = sampler.sample(posterior, 200, 8, rng())
    x = draws.theta[..., 0]
    assert ((x >= box[0, 0]) & (x <= box[0, 1])).all()
    assert not np.isin(x, box[0]).any()  # rejected, not clipped
    far = np.array(box)
    far[0] = mode[0] + 5.0 * sd[0], mode[0] + 9.0 * sd[0]
    with pytest.raises(InvalidInputError, match="box excludes the mode"):
        sampler.sample(
            Posterior(linear_problem(1).problem, Gaussian(), PRIOR, box=far), 9, 2, rng()
        )


@pytest.mark.parametrize("sampler", **NAMED)
def test_unknown_noise_parameters_come_out_in_their_own_units(sampler):
    if isinstance(sampler, Exact):
        pytest.skip("has no unknown noise parameters, and says so")
    problem = linear_problem(2, n=200).problem
    unknown = (NoiseParameter("nu", 6.0, 0.6), NoiseParameter("scale", 1.0, 0.4))
    posterior = Posterior(problem, StudentT(6.0), PRIOR, unknown)
    draws = sampler.sample(posterior, 300, 2 if isinstance(sampler, Nuts) else 12, rng())
    assert draws.names[-2:] == ("noise.nu", "noise.scale")
    assert (draws.theta[..., -2:] > 0.0).all()
    assert draws.mean[-1] == pytest.approx(1.0, abs=0.2)
    assert "noise.nu: median 6" in str(draws)


@pytest.mark.parametrize("sampler", **NAMED)
def test_an_emitter_is_sampled_exactly_where_bearings_are_not_linear(sampler):
    problem = BearingProblem.of(passive_reports(2, n=12))
    prior = GaussianPrior.from_sd(np.full(2, 2e3), EMITTER)
    posterior = Posterior(problem, StudentT(5.0), prior)
    if isinstance(sampler, Exact):
        with pytest.raises(InvalidInputError, match="no closed form"):
            sampler.sample(posterior, 10, 2, rng())
        return
    draws = sampler.sample(posterior, *size(sampler), rng())
    mean, variance = quadrature(posterior)
    scores = z_scores(draws, mean, variance)
    assert np.abs(scores).max() < limit(scores, 1e-4)
    # negative control: the linear form at the mode is another posterior
    linear = quadrature(Posterior(posterior.linear, StudentT(5.0), prior))
    assert np.abs(linear[0] - mean).max() > 0.05 * np.sqrt(variance).max()


def quadrature(posterior, reach=9.0, points=401):
    """Mean and variance of two unknowns, from the density on a grid."""
    laplace = posterior.laplace
    z = np.linspace(-reach, reach, points)
    grid = np.stack(np.meshgrid(z, z, indexing="ij"), axis=-1)
    x = laplace.mean + grid @ laplace.root.T
    log_prob = posterior.log_prob(x.reshape(-1, 2)).reshape(points, points)
    weight = np.exp(log_prob - log_prob.max())
    edge = max(weight[0].max(), weight[-1].max(), weight[:, 0].max(), weight[:, -1].max())
    assert edge < 1e-5
    weight /= weight.sum()
    mean = np.einsum("ab,abd->d", weight, x)
    return mean, np.einsum("ab,abd->d", weight, (x - mean) ** 2)


@pytest.mark.parametrize("sampler", **NAMED)
def test_settings_show_in_the_result(sampler):
    draws = sampler.sample(gaussian_posterior(), 5, 2, rng())
    assert type(sampler).__name__ in draws.sampler
    assert "theta[0]" in str(draws)
    assert "prior" in str(draws)
