"""Samplers against references that are not ours: quadrature and an independent package."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from probreg import GaussianPrior, LinearProblem, Posterior
from probreg.noise import Contaminated, Gaussian, Huber, Hyperbolic, StudentT
from probreg.prior import NoiseParameter
from probreg.samplers import Gibbs, Importance, MetropolisHastings, Nuts
from tests.conformance.test_samplers import quadrature
from tests.conftest import linear_problem
from tests.judge import limit, z_scores

REFERENCE = Path(__file__).parents[1] / "reference"
SAMPLERS = [MetropolisHastings(), Gibbs(), Importance(), Nuts()]
LAWS = [
    Gaussian(),
    Hyperbolic(),
    Hyperbolic(0.5, componentwise=True),
    StudentT(3.0),
    StudentT(3.0, componentwise=True),
    Contaminated(0.15, 8.0),
    Huber(1.0),
]


def draw(sampler, posterior, seed=5):
    draws, chains = (1500, 2) if isinstance(sampler, Nuts) else (800, 24)
    return sampler.sample(posterior, draws, chains, np.random.default_rng(seed))


# NUTS is slow: all its laws are in the study `calibration_nuts`, here the three that differ most
UNHURRIED = [*SAMPLERS[:-1], pytest.param(SAMPLERS[-1], marks=pytest.mark.slow)]
QUICK = (Gaussian, StudentT, Contaminated)
CASES = [
    (s, law) for s in SAMPLERS for law in LAWS if not isinstance(s, Nuts) or type(law) in QUICK
]


@pytest.mark.parametrize(("sampler", "law"), CASES, ids=lambda x: type(x).__name__)
def test_two_unknowns_agree_with_quadrature(sampler, law):
    # 4 scores in each of 26 cases; family-wise false-alarm rate 1e-3 over all of them
    if isinstance(sampler, Gibbs) and not law.scale_mixture:
        pytest.skip("no Gaussian scale mixture")
    problem = linear_problem(3, n=15, m=2, p=2, noise=2.0).problem
    posterior = Posterior(problem, law, GaussianPrior.from_sd(np.full(2, 2.0)))
    mean, variance = quadrature(posterior)
    scores = z_scores(draw(sampler, posterior), mean, variance)
    assert np.abs(scores).max() < limit(np.empty(4 * 26), 1e-3)


def stored(name):
    with np.load(REFERENCE / "posteriors.npz") as file:
        return {key.removeprefix(f"{name}_"): file[key] for key in file if key.startswith(name)}


def test_provenance_is_recorded():
    facts = json.loads((REFERENCE / "posteriors.json").read_text())
    assert {"package", "version", "sampler", "seed", "made"} <= set(facts)
    assert all(result["least_ess"] > 40_000 for result in facts["results"].values())


# 12 scores in each of eight cases; family-wise false-alarm rate 1e-3 over all of them
LIMIT = limit(np.empty(12 * 8), 1e-3)


def worst(draws, data):
    """Largest |z| of the moments against those stored, both Monte-Carlo errors counted."""
    scores = z_scores(
        draws, data["mean"], data["sd"] ** 2, 200, data["mean_error"], data["variance_error"]
    )
    return np.abs(scores).max()


@pytest.mark.parametrize("sampler", UNHURRIED, ids=lambda s: type(s).__name__)
def test_four_unknowns_with_nu_and_scale_agree_with_the_package(sampler):
    data = stored("student")
    problem = LinearProblem(data["y"], data["B"], np.ones((len(data["y"]), 1, 1)))
    unknown = (NoiseParameter("nu", 5.0, 0.5), NoiseParameter("scale", 1.0, 0.5))
    prior = GaussianPrior.from_sd(data["prior_sd"])
    draws = draw(sampler, Posterior(problem, StudentT(5.0), prior, unknown))
    assert worst(draws, data) < LIMIT


@pytest.mark.parametrize("sampler", UNHURRIED, ids=lambda s: type(s).__name__)
def test_six_unknowns_under_the_contaminated_law_agree_with_the_package(sampler):
    data = stored("mixed")
    problem = LinearProblem(data["y"], data["B"], np.tile(np.eye(3), (len(data["y"]), 1, 1)))
    prior = GaussianPrior.from_sd(data["prior_sd"])
    draws = draw(sampler, Posterior(problem, Contaminated(0.1, 10.0), prior))
    assert worst(draws, data) < LIMIT


def test_the_judge_sees_a_posterior_that_is_another():
    # negative control: a wrong scale of the noise, by a fifth
    data = stored("mixed")
    R = np.tile(1.44 * np.eye(3), (len(data["y"]), 1, 1))
    problem = LinearProblem(data["y"], data["B"], R)
    prior = GaussianPrior.from_sd(data["prior_sd"])
    draws = draw(MetropolisHastings(), Posterior(problem, Contaminated(0.1, 10.0), prior))
    assert worst(draws, data) > LIMIT
