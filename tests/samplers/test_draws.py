"""What draws say of themselves, and their one door to ArviZ."""

from __future__ import annotations

import arviz
import numpy as np
import pytest

from probreg import GaussianPrior, Posterior, arviz_adapter
from probreg.errors import InvalidInputError
from probreg.noise import Contaminated, Gaussian, StudentT
from probreg.prior import NoiseParameter
from probreg.samplers import Exact, Gibbs, Importance, MetropolisHastings
from probreg.samplers.moves import LocalGaussian
from tests.conftest import linear_problem

PRIOR = GaussianPrior.from_sd(np.full(4, 3.0))


def rng(seed=4):
    return np.random.default_rng(seed)


@pytest.fixture(scope="module")
def draws():
    posterior = Posterior(linear_problem(1).problem, StudentT(5.0), PRIOR)
    return MetropolisHastings().sample(posterior, 300, 4, rng())


def test_arviz_gets_every_group(draws):
    data = draws.to_arviz(rng())
    groups = {
        "posterior",
        "sample_stats",
        "log_likelihood",
        "posterior_predictive",
        "observed_data",
    }
    found = set(data.children) if arviz_adapter.is_new() else set(data.groups())
    assert groups <= found
    np.testing.assert_array_equal(data["posterior"]["theta[2]"].values, draws.theta[..., 2])
    rows = data["log_likelihood"]["rows"].values
    np.testing.assert_allclose(
        rows.sum(axis=-1), draws.stats["log_prob"] - draws.posterior.log_prior(draws.theta)
    )
    np.testing.assert_array_equal(data["sample_stats"]["lp"].values, draws.stats["log_prob"])
    assert data["posterior"].attrs["gamma"] == 1.0
    assert arviz.summary(data, var_names=["theta[0]"]).shape[0] == 1


def test_predictive_rows_scatter_as_the_data(draws):
    data = draws.to_arviz(rng())
    replicated = data["posterior_predictive"]["y"].values
    observed = data["observed_data"]["y"].values
    assert replicated.shape == (4, 300, *observed.shape)
    # spread of the replicated rows: the law's own about the fits, whose spread is small
    expected = np.sqrt(5.0 / 3.0)
    assert np.std(replicated) == pytest.approx(expected, rel=0.15)


def test_summary_has_intervals_diagnostics_and_priors(draws):
    table = draws.summary(0.8)
    assert list(table.index) == list(draws.names)
    np.testing.assert_allclose(
        table[["10%", "90%"]].to_numpy(), np.quantile(draws.flat, [0.1, 0.9], axis=0).T
    )
    assert (table["ess_bulk"] > 100).all()
    assert "theta[0]: normal 0 +- 3" in table.attrs["prior"]
    assert "not a posterior" not in table.columns


def test_bad_mixing_is_said_first():
    posterior = Posterior(linear_problem(1).problem, Gaussian(), PRIOR)
    slow = MetropolisHastings((LocalGaussian(step=0.02),), warmup=0)
    bad = slow.sample(posterior, 60, 4, rng())
    said = str(bad).splitlines()
    assert any("R-hat is" in line and line.startswith("warning") for line in said[:2])
    assert any("effective draws" in line for line in said[:3])
    few = Exact().sample(posterior, 2, 2, rng())
    assert "too few draws" in few.warnings[0]
    with pytest.raises(InvalidInputError, match="too few for this diagnostic"):
        few.summary()


def test_importance_weights_that_fail_are_said():
    # a proposal far too narrow: light tails on a heavy-tailed posterior of few rows
    problem = linear_problem(3, n=3, m=2, p=2, noise=1.0).problem
    posterior = Posterior(problem, StudentT(0.6), GaussianPrior.from_sd(np.full(2, 1e3)))
    found = Importance(df=1000.0).sample(posterior, 500, 4, rng())
    assert found.facts["pareto_k"] > 0.7
    assert any("Pareto k" in text for text in found.warnings)


def test_evidence_of_a_gaussian_posterior_is_the_closed_form():
    from scipy import stats

    problem = linear_problem(5, n=6, m=2, p=4).problem
    found = Importance().sample(Posterior(problem, Gaussian(), PRIOR), 2000, 4, rng())
    B, y = problem.B.reshape(12, 4), problem.y.ravel()
    spread = B @ PRIOR.covariance @ B.T
    for k, R in enumerate(problem.R):
        spread[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] += R
    expected = stats.multivariate_normal(np.zeros(12), spread).logpdf(y)
    assert found.facts["log_evidence"] == pytest.approx(expected, abs=0.02)


def test_precisions_drawn_by_gibbs_follow_the_noise_walk():
    unknown = (NoiseParameter("rate", 0.1, 0.5), NoiseParameter("scale", 8.0, 0.3))
    posterior = Posterior(linear_problem(1, n=150).problem, Contaminated(0.1, 8.0), PRIOR, unknown)
    found = Gibbs(warmup=100).sample(posterior, 200, 8, rng())
    assert 0.2 < found.facts["noise_acceptance"] < 0.5
    assert ((found.theta[..., 4] > 0.0) & (found.theta[..., 4] < 1.0)).all()
    assert (found.theta[..., 5] > 1.0).all()


def test_intervals_ask_for_a_probability(draws):
    with pytest.raises(InvalidInputError, match="probability is 90"):
        draws.interval(90)


def test_log_prob_follows_the_draws_of_gibbs_with_unknown_noise():
    unknown = (NoiseParameter("nu", 5.0, 0.5),)
    posterior = Posterior(linear_problem(1).problem, StudentT(5.0), PRIOR, unknown)
    found = Gibbs(warmup=5).sample(posterior, 20, 3, rng())
    expected = posterior.log_prob(posterior.free(found.theta))
    np.testing.assert_allclose(found.stats["log_prob"], expected)


def test_predictive_rows_have_the_spread_of_their_own_dimension():
    # rows of two and of four components under a law that depends on the dimension
    from probreg import LinearProblem
    from probreg.noise import Hyperbolic

    base = linear_problem(6, n=60, m=4, p=2).problem
    size = np.where(np.arange(60) % 2, 2, 4)
    blank = np.arange(4) >= size[:, None]
    problem = LinearProblem(
        np.where(blank, 0.0, base.y),
        np.where(blank[..., None], 0.0, base.B),
        np.tile(np.eye(4), (60, 1, 1)),
        size=size,
    )
    law = Hyperbolic(1e-3)
    posterior = Posterior(problem, law, GaussianPrior.from_sd(np.full(2, 1e-4)))
    found = Importance().sample(posterior, 400, 2, rng())
    replicated = found.to_arviz(rng(), log_likelihood=False)["posterior_predictive"]["y"].values
    for m in (2, 4):
        spread = replicated[:, :, size == m, :m]
        centred = spread - spread.mean(axis=(0, 1))
        assert centred.var() == pytest.approx(law.covariance_factor(m), rel=0.05)
    assert (replicated[:, :, size == 2, 2:] == 0.0).all()


def test_a_box_is_said_with_the_priors():
    box = np.array([[0.5, np.inf]] + [[-np.inf, np.inf]] * 3)
    posterior = Posterior(linear_problem(1).problem, Gaussian(), None, box=box)
    mode = posterior.mode().theta[0]
    box[0, 0] = mode - 0.1
    cut = Posterior(linear_problem(1).problem, Gaussian(), None, box=box)
    assert "theta[0]: cut to" in str(MetropolisHastings().sample(cut, 20, 4, rng()))


def test_two_moves_of_one_kind_are_told_apart():
    moves = (LocalGaussian(0.1), LocalGaussian(3.0))
    posterior = Posterior(linear_problem(1).problem, Gaussian(), PRIOR)
    found = MetropolisHastings(moves).sample(posterior, 50, 8, rng())
    rates = found.facts["acceptance"]
    assert rates["LocalGaussian[0]"] > 0.6 > rates["LocalGaussian[1]"]
