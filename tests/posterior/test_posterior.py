"""The posterior with unknown noise parameters: densities, gradients, Laplace, Pyro, checks."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from probreg import BearingProblem, GaussianPrior, Posterior, ReportProblem
from probreg.errors import ImproperLawError, InvalidInputError
from probreg.noise import Contaminated, Gaussian, HardReject, Huber, Hyperbolic, StudentT
from probreg.prior import NoiseParameter
from tests.conftest import PAIR_BIAS, linear_problem, passive_reports, polar_reports, radar_pair

PRIOR = GaussianPrior.from_sd(np.full(4, 3.0), np.full(4, 0.2))
CASES = {
    "student": (StudentT(4.0), (NoiseParameter("nu", 5.0, 0.6), NoiseParameter("scale", 1.2, 0.3))),
    "mixed": (
        Contaminated(0.1, 8.0),
        (
            NoiseParameter("rate", 0.15, 0.5),
            NoiseParameter("scale", 6.0, 0.4),
            NoiseParameter("core_scale", 0.9, 0.2),
        ),
    ),
    "apart": (StudentT(4.0, componentwise=True), (NoiseParameter("nu", 5.0, 0.6),)),
    "laplace": (Hyperbolic(0.2), (NoiseParameter("scale", 1.0, 0.4),)),
    "huber": (Huber(1.2), (NoiseParameter("scale", 1.0, 0.4),)),
    "gaussian": (Gaussian(), (NoiseParameter("scale", 1.0, 0.4),)),
}


def make(name, n=40):
    noise, unknown = CASES[name]
    return Posterior(linear_problem(3, n=n).problem, noise, PRIOR, unknown)


def states(posterior, k=5):
    rng = np.random.default_rng(1)
    z = rng.normal(size=(k, posterior.dim))
    return posterior.laplace.mean + 0.5 * z @ posterior.laplace.root.T


@pytest.mark.parametrize("name", CASES)
def test_density_is_likelihood_times_prior_in_free_coordinates(name):
    posterior = make(name)
    x = states(posterior)
    values = posterior.natural(x)
    problem, noise = posterior.problem, posterior.noise
    for k in range(len(x)):
        fields = {p.name: values[k, 4 + j] for j, p in enumerate(posterior.noise_prior)}
        law = type(noise)(**{**vars(noise), **fields})
        theta = values[k, :4]
        rows = Posterior(problem, law, PRIOR)
        expected = rows.log_likelihood(theta).sum() + PRIOR.log_density(theta)
        for j, p in enumerate(posterior.noise_prior):
            support = noise.supports[p.name]
            prior = stats.norm(support.free(p.median), p.spread)
            expected += prior.logpdf(support.free(values[k, 4 + j]))
        assert posterior.log_prob(x[k]) == pytest.approx(expected, rel=1e-10)
    np.testing.assert_allclose(posterior.free(values), x, atol=1e-9)
    np.testing.assert_allclose(
        posterior.log_likelihood(x).sum(axis=-1) + posterior.log_prior(x), posterior.log_prob(x)
    )


@pytest.mark.parametrize("name", CASES)
def test_gradient_is_the_finite_difference(name):
    posterior = make(name)
    x = states(posterior)
    gradient = posterior.grad_log_prob(x)
    for k in range(posterior.dim):
        h = 1e-6 * np.eye(posterior.dim)[k]
        slope = (posterior.log_prob(x + h) - posterior.log_prob(x - h)) / 2e-6
        np.testing.assert_allclose(gradient[:, k], slope, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", CASES)
def test_laplace_is_the_mode_and_its_curvature(name):
    posterior = make(name, n=300)
    laplace = posterior.laplace
    sd = np.sqrt(np.diag(laplace.covariance))
    assert (np.abs(posterior.grad_log_prob(laplace.mean)) * sd < 2e-2).all()
    if name == "laplace":
        return  # kinked: a finite difference at single rows is not the mean curvature
    hessian = np.empty((posterior.dim, posterior.dim))
    for k in range(posterior.dim):
        h = 1e-3 * sd[k] * np.eye(posterior.dim)[k]
        ends = [posterior.grad_log_prob(laplace.mean + s * h) for s in (1.0, -1.0)]
        hessian[k] = (ends[1] - ends[0]) / (2e-3 * sd[k])
    expected = np.linalg.inv(hessian)
    np.testing.assert_allclose(
        np.sqrt(np.diag(laplace.covariance)), np.sqrt(np.diag(expected)), rtol=0.03
    )


@pytest.mark.parametrize("name", CASES)
def test_pyro_model_has_the_same_density_and_gradient(name):
    import torch
    from pyro import poutine

    posterior = make(name)
    model = posterior.to_pyro()
    for x in states(posterior, 3):
        sites = {"theta": torch.tensor(x[:4], requires_grad=True)}
        for k, p in enumerate(posterior.noise_prior, 4):
            sites[f"noise.{p.name}.free"] = torch.tensor(x[k], requires_grad=True)
        trace = poutine.trace(poutine.condition(model, sites)).get_trace()
        total = trace.log_prob_sum()
        assert float(total.detach()) == pytest.approx(float(posterior.log_prob(x)), rel=1e-9)
        total.backward()
        gradient = np.concatenate([np.ravel(site.grad.numpy()) for site in sites.values()])
        np.testing.assert_allclose(gradient, posterior.grad_log_prob(x), rtol=1e-9, atol=1e-9)
        for k, p in enumerate(posterior.noise_prior, 4):
            value = float(trace.nodes[f"noise.{p.name}"]["value"].detach())
            assert value == pytest.approx(posterior.natural(x)[k])


def test_pyro_model_of_bearings_with_a_flat_prior():
    from pyro import poutine

    posterior = Posterior(BearingProblem.of(passive_reports(1)), StudentT(4.0))
    import torch

    x = posterior.laplace.mean + 20.0
    conditioned = poutine.condition(posterior.to_pyro(), {"theta": torch.tensor(x)})
    total = poutine.trace(conditioned).get_trace().log_prob_sum()
    assert float(total) == pytest.approx(float(posterior.log_prob(x)), rel=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_wild_proposals_have_a_density_and_not_an_error(name):
    # a diverging trajectory may go anywhere
    posterior = make(name)
    far = np.tile(posterior.laplace.mean, (2, 1))
    far[:, 4:] = np.array([[900.0], [-900.0]])
    value, gradient = posterior.log_prob_and_grad(far)
    assert not np.isnan(value).any()
    assert (value < posterior.log_prob(posterior.laplace.mean)).all()
    assert posterior.log_prob(far[0]) == pytest.approx(value[0])
    assert not np.isnan(gradient).any()


def test_a_box_cuts_the_density():
    box = np.array([[0.0, 1.0], [-np.inf, np.inf], [-5.0, 5.0], [-5.0, 5.0]])
    free = Posterior(linear_problem(3).problem, Gaussian(), PRIOR)
    cut = Posterior(linear_problem(3).problem, Gaussian(), PRIOR, box=box)
    inside, outside = np.array([0.5, 9.0, 0.0, 0.0]), np.array([1.5, 0.0, 0.0, 0.0])
    assert cut.log_prob(inside) == free.log_prob(inside)
    assert cut.log_prob(outside) == -np.inf
    for bad in (box[:2], box[:, ::-1], np.full((4, 2), np.nan)):
        with pytest.raises(InvalidInputError, match="box must be"):
            Posterior(linear_problem(3).problem, Gaussian(), PRIOR, box=bad)


def test_noise_parameters_are_checked():
    problem = linear_problem(3).problem
    with pytest.raises(InvalidInputError, match="has no parameter 'rate'"):
        Posterior(problem, StudentT(4.0), PRIOR, (NoiseParameter("rate", 0.1),))
    with pytest.raises(InvalidInputError, match="not a value it may take"):
        Posterior(problem, Contaminated(), PRIOR, (NoiseParameter("rate", 1.2),))
    with pytest.raises(InvalidInputError, match="two priors"):
        Posterior(
            problem, StudentT(), PRIOR, (NoiseParameter("nu", 4.0), NoiseParameter("nu", 5.0))
        )
    with pytest.raises(ImproperLawError, match="no density"):
        Posterior(problem, HardReject(), PRIOR, (NoiseParameter("scale", 1.0),))
    with pytest.raises(InvalidInputError, match="spread"):
        NoiseParameter("nu", 4.0, 0.0)
    with pytest.raises(InvalidInputError, match=r"must hold theta\[0\].*noise\.nu"):
        Posterior(problem, StudentT(), PRIOR, (NoiseParameter("nu", 4.0),)).log_prob(np.zeros(4))


def test_default_priors_come_from_the_sensors():
    problem = ReportProblem(polar_reports(radar_pair(), PAIR_BIAS, seed=1))
    prior = GaussianPrior.default(problem)
    degree = np.deg2rad(1.0)
    np.testing.assert_allclose(np.sqrt(np.diag(prior.covariance)), [100.0, degree, degree] * 2)
    named = GaussianPrior.by_name(problem, {"j.range": (30.0, 5.0)})
    np.testing.assert_allclose(named.mean, [0, 0, 0, 30.0, 0, 0])
    assert named.covariance[3, 3] == 25.0
    with pytest.raises(InvalidInputError, match="no unknown 'k.range'"):
        GaussianPrior.by_name(problem, {"k.range": (0.0, 1.0)})
    bearings = BearingProblem.of(passive_reports(1), sensor_bias=True)
    wide = GaussianPrior.default(bearings)
    assert np.sqrt(wide.covariance[0, 0]) > 5e4
    assert np.sqrt(wide.covariance[2, 2]) == pytest.approx(degree)


def test_noise_priors_draw_what_their_density_says():
    # 20 000 draws: Kolmogorov-Smirnov at 1e-4
    rng = np.random.default_rng(2)
    for noise, unknown in CASES.values():
        for p in unknown:
            found = [p.sample(rng, noise) for _ in range(2000)]
            free = noise.supports[p.name].free(np.array(found))
            law = stats.norm(p.free_median(noise), p.spread)
            assert stats.kstest(free, law.cdf).pvalue > 1e-4


def test_pyro_model_with_a_box_is_minus_infinity_outside():
    import torch
    from pyro import poutine

    box = np.array([[0.0, 1.0]] + [[-5.0, 5.0]] * 3)
    posterior = Posterior(linear_problem(3).problem, Gaussian(), PRIOR, box=box)
    for x, inside in ((np.array([0.5, 0.1, 0.2, 0.3]), True), (np.full(4, 2.0), False)):
        model = poutine.condition(posterior.to_pyro(), {"theta": torch.tensor(x)})
        total = float(poutine.trace(model).get_trace().log_prob_sum())
        assert total == pytest.approx(float(posterior.log_prob(x))) if inside else total == -np.inf


def test_slips_in_the_arguments_are_named():
    problem = linear_problem(3).problem
    lone = Posterior(problem, StudentT(4.0), PRIOR, NoiseParameter("nu", 4.0))
    assert lone.names[-1] == "noise.nu"
    with pytest.raises(InvalidInputError, match="GaussianPrior is needed"):
        Posterior(problem, StudentT(4.0), np.ones(4))
    with pytest.raises(InvalidInputError, match="one number a parameter"):
        Posterior(problem, StudentT(np.array([4.0, 5.0])), PRIOR)
