"""Calibration, coverage and comparison of laws, each with a control that must fail."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import stats

from probreg import GaussianPrior, LinearProblem, Posterior
from probreg.diagnostics import (
    Case,
    Coverage,
    Ranks,
    binomial_limits,
    calibrate,
    compare_laws,
    coverage,
    leave_one_out,
    normal_interval,
    outlier_probability,
    rank_truth,
)
from probreg.errors import InvalidInputError
from probreg.noise import Contaminated, Gaussian, Hyperbolic, StudentT
from probreg.prior import NoiseParameter
from probreg.samplers import Exact, Gibbs, MetropolisHastings
from tests.conftest import linear_problem, symmetric_roots

PRIOR = GaussianPrior.from_sd(np.array([2.0, 0.5]), np.array([1.0, -1.0]))


@dataclass(frozen=True)
class Family:
    """Truth from the prior, rows of a fixed design."""

    noise: object
    unknown: tuple = ()
    n: int = 30

    def __call__(self, rng):
        design = linear_problem(2, n=self.n, m=2, p=2).problem
        theta = PRIOR.sample(rng)
        values = {p.name: p.sample(rng, self.noise) for p in self.unknown}
        law = type(self.noise)(**{**vars(self.noise), **values})
        noise = (symmetric_roots(design.R) @ law.sample(rng, self.n, 2)[..., None])[..., 0]
        problem = LinearProblem(design.B @ theta + noise, design.B, design.R)
        posterior = Posterior(problem, self.noise, PRIOR, self.unknown)
        return Case(posterior, posterior.free(np.array([*theta, *values.values()])))


@dataclass(frozen=True)
class Stretched:
    """A broken sampler: its draws lie too far out or too near."""

    factor: float

    def sample(self, posterior, num_draws, num_chains, rng):
        found = Exact().sample(posterior, num_draws, num_chains, rng)
        mean = posterior.laplace.mean
        object.__setattr__(found, "theta", mean + self.factor * (found.theta - mean))
        return found


def test_a_right_sampler_is_calibrated():
    # family-wise false-alarm rate 1e-3
    ranks = calibrate(Family(Gaussian()), Exact(), 400, np.random.default_rng(1))
    assert ranks.names == ("theta[0]", "theta[1]", "log_likelihood")
    assert ranks.p_values.min() >= 1e-3 / 3
    ranks.require(1e-3)  # does not raise
    assert all(c.honest(1e-4) for c in ranks.coverage(0.9))
    low, high = ranks.band(1e-3)
    for name in ranks.names:
        _, gap = ranks.ecdf_difference(name)
        assert ((gap >= low) & (gap <= high)).all()
        assert ranks.histogram(name)[1].sum() == 400


@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_an_error_of_scale_of_a_fifth_is_seen(factor):
    ranks = calibrate(Family(Gaussian()), Stretched(factor), 1000, np.random.default_rng(2))
    with pytest.raises(InvalidInputError, match=r"not calibrated: .*theta\[0\]"):
        ranks.require(1e-3)
    assert not all(c.honest(1e-3) for c in ranks.coverage(0.9))


@pytest.mark.parametrize(
    ("noise", "unknown", "sampler"),
    [
        (StudentT(4.0), (), MetropolisHastings(warmup=15)),
        (Hyperbolic(), (), Gibbs(warmup=40)),
        (
            StudentT(4.0),
            (NoiseParameter("nu", 5.0, 0.5), NoiseParameter("scale", 1.0, 0.3)),
            MetropolisHastings(warmup=25),
        ),
        (
            Contaminated(0.1, 8.0),
            (NoiseParameter("rate", 0.1, 0.5), NoiseParameter("core_scale", 1.0, 0.3)),
            Gibbs(warmup=40),
        ),
    ],
    ids=str,
)
def test_samplers_are_calibrated_with_fixed_and_unknown_noise(noise, unknown, sampler):
    # family-wise false-alarm rate 1e-3 a case; the long run is the study `calibration`
    ranks = calibrate(Family(noise, unknown), sampler, 150, np.random.default_rng(3))
    assert ranks.p_values.min() >= 1e-3 / len(ranks.names)


def test_wrong_noise_in_the_model_is_seen():
    def family(rng):
        case = Family(StudentT(3.0))(rng)
        return Case(Posterior(case.posterior.problem, Gaussian(), PRIOR), case.truth)

    ranks = calibrate(family, Exact(), 400, np.random.default_rng(4))
    with pytest.raises(InvalidInputError, match="log_likelihood"):
        ranks.require(1e-3)


def test_p_values_are_uniform_under_the_null():
    # 300 p-values below 0.1: exact binomial limits at a false-alarm rate of 1e-4
    rng = np.random.default_rng(5)
    ranks = rng.integers(0, 100, (200, 300))
    p = Ranks(ranks, 99, tuple(map(str, range(300)))).p_values
    low, high = binomial_limits(300, 0.1, 1e-4)
    assert low <= np.mean(p < 0.1) <= high


def test_bands_hold_their_false_alarm_rate():
    rng = np.random.default_rng(6)
    ranks = Ranks(rng.integers(0, 100, (100, 400)), 99, tuple(map(str, range(400))))
    low, high = ranks.band(0.1)
    out = [((g < low - 1e-12) | (g > high + 1e-12)).any()
           for g in (ranks.ecdf_difference(n)[1] for n in ranks.names)]  # fmt: skip
    limits = binomial_limits(400, 0.1, 1e-4)
    assert limits[0] - 0.03 <= np.mean(out) <= limits[1]  # discrete: never above


def test_coverage_needs_enough_draws_to_have_a_tail():
    ranks = np.random.default_rng(6).integers(0, 10, (200, 1))
    nine, ten = (Ranks(ranks, keep, ("x",)) for keep in (9, 10))
    with pytest.raises(InvalidInputError, match=r"among 9 draws .* 0.9: they would hold every"):
        nine.coverage(0.9)
    with pytest.raises(InvalidInputError, match="hold no rank"):
        nine.coverage(0.05)
    with pytest.raises(InvalidInputError, match="nominal is 90"):
        nine.coverage(90)
    (found,) = ten.coverage(0.9)
    assert found.nominal == pytest.approx(9.0 / 11.0)
    assert found.held == ((ranks >= 1) & (ranks < 10)).sum()
    assert nine.coverage(0.8)[0].honest(1e-4)


def test_ranks_are_counted_among_the_draws_kept():
    case = Family(Gaussian())(np.random.default_rng(7))
    draws = Exact().sample(case.posterior, 30, 4, np.random.default_rng(8))
    ranks, _ = rank_truth(draws, case.truth, 40, np.random.default_rng(9))
    order = np.swapaxes(draws.theta, 0, 1).reshape(120, 2)[119 - 3 * np.arange(40)]
    np.testing.assert_array_equal(ranks[:2], (order < case.truth).sum(axis=0))
    with pytest.raises(InvalidInputError, match="120 draws are too few"):
        rank_truth(draws, case.truth, 121, np.random.default_rng(9))


# -- coverage ------------------------------------------------------------------------------


@pytest.mark.parametrize(("n", "p", "alarm"), [(20, 0.9, 0.05), (400, 0.5, 1e-3), (1000, 0.9, 0.2)])
def test_binomial_limits_are_exact(n, p, alarm):
    low, high = (round(n * x) for x in binomial_limits(n, p, alarm))
    law = stats.binom(n, p)
    assert law.cdf(low - 1) <= 0.5 * alarm < law.cdf(low)
    assert law.sf(high) <= 0.5 * alarm < law.sf(high - 1)


@pytest.mark.parametrize(("held", "trials"), [(0, 10), (10, 10), (37, 50)])
def test_confidence_is_clopper_pearson(held, trials):
    expected = stats.binomtest(held, trials).proportion_ci(0.95, "exact")
    assert Coverage(held, trials, 0.9).confidence() == pytest.approx(tuple(expected))


def test_intervals_are_counted():
    truth = np.array([[0.0, 5.0], [0.0, 5.0], [0.0, 5.0]])
    intervals = np.array([[[-1, 1], [0, 1]], [[0, 2], [4, 6]], [[1, 2], [5, 9]]], dtype=float)
    found = coverage(intervals, truth, 0.5)
    assert [c.held for c in found] == [2, 2]
    with pytest.raises(InvalidInputError, match="all finite"):
        coverage(np.full((3, 2, 2), np.nan), truth, 0.5)
    with pytest.raises(InvalidInputError, match="binomial_limits"):
        binomial_limits(0, 0.5, 0.1)
    half = normal_interval(np.zeros(2), np.diag([1.0, 4.0]), 0.9)
    np.testing.assert_allclose(half[:, 1], stats.norm.isf(0.05) * np.array([1.0, 2.0]))


# -- comparison of laws -----------------------------------------------------------------------


def draws_under(noise, problem, seed=1):
    posterior = Posterior(problem, noise, PRIOR)
    return MetropolisHastings().sample(posterior, 400, 16, np.random.default_rng(seed))


def test_leave_one_out_is_that_of_refitting_without_the_row():
    problem = Family(Gaussian(), n=25)(np.random.default_rng(3)).posterior.problem
    found = leave_one_out(draws_under(Gaussian(), problem))
    expected = []
    for k in range(25):
        keep = np.arange(25) != k
        rest = LinearProblem(problem.y[keep], problem.B[keep], problem.R[keep])
        laplace = Posterior(rest, Gaussian(), PRIOR).laplace
        spread = problem.B[k] @ laplace.covariance @ problem.B[k].T + problem.R[k]
        law = stats.multivariate_normal(problem.B[k] @ laplace.mean, spread)
        expected.append(law.logpdf(problem.y[k]))
    np.testing.assert_allclose(found.pointwise, expected, atol=0.08)
    assert found.elpd == pytest.approx(np.sum(expected), abs=0.2)
    assert (found.pareto_k < 0.7).all()


@pytest.mark.parametrize("true", [Gaussian(), StudentT(2.0), Contaminated(0.15, 12.0)])
def test_the_law_that_made_the_data_is_found(true):
    problem = Family(true, n=300)(np.random.default_rng(11)).posterior.problem
    laws = {
        "Gaussian": Gaussian(),
        "StudentT": StudentT(2.0),
        "Contaminated": Contaminated(0.15, 12.0),
    }
    ranked = compare_laws({name: draws_under(law, problem) for name, law in laws.items()})
    best = ranked[0]
    assert best.name == type(true).__name__
    assert best.behind == best.standard_error == 0.0
    assert all(r.behind > 0.0 for r in ranked[1:])


def test_rows_that_are_outliers_are_told():
    rng = np.random.default_rng(12)
    problem = Family(Gaussian(), n=60)(rng).posterior.problem
    y = problem.y.copy()
    y[:6] += 25.0
    spoiled = LinearProblem(y, problem.B, problem.R)
    draws = draws_under(Contaminated(0.1, 10.0), spoiled)
    probability = outlier_probability(draws)
    assert (probability[:6] > 0.99).all()
    assert np.median(probability[6:]) < 0.05
    v = draws.posterior.rows.residual(draws.flat)
    narrow = 0.9 * np.exp(-0.5 * (v**2).sum(axis=-1))
    wide = 0.1 / 100.0 * np.exp(-0.005 * (v**2).sum(axis=-1))
    np.testing.assert_allclose(probability, (wide / (wide + narrow)).mean(axis=0), atol=1e-9)


def test_comparisons_refuse_what_they_cannot_compare():
    problem = Family(Gaussian())(np.random.default_rng(1)).posterior.problem
    other = Family(Gaussian(), n=31)(np.random.default_rng(1)).posterior.problem
    one, two = draws_under(Gaussian(), problem), draws_under(Gaussian(), other)
    with pytest.raises(InvalidInputError, match="have different rows"):
        compare_laws({"a": one, "b": two})
    with pytest.raises(InvalidInputError, match="at least two"):
        compare_laws({"a": one})
    with pytest.raises(InvalidInputError, match="take Contaminated"):
        outlier_probability(one)
    sharp = MetropolisHastings(gamma=2.0).sample(one.posterior, 20, 4, np.random.default_rng(1))
    with pytest.raises(InvalidInputError, match="not from the posterior"):
        leave_one_out(sharp)


def test_the_same_rows_in_other_units_are_not_the_same():
    problem = Family(Gaussian())(np.random.default_rng(1)).posterior.problem
    km = LinearProblem(problem.y / 1e3, problem.B / 1e3, problem.R / 1e6)
    with pytest.raises(InvalidInputError, match="of other units"):
        compare_laws({"m": draws_under(StudentT(), problem), "km": draws_under(Gaussian(), km)})


def test_empty_or_impossible_studies_are_refused():
    with pytest.raises(InvalidInputError, match="must be 1 or more"):
        calibrate(Family(Gaussian()), Exact(), 0, np.random.default_rng(1))
    with pytest.raises(InvalidInputError, match="nominal is 90"):
        coverage(np.zeros((3, 2, 2)), np.zeros(2), 90)
    with pytest.raises(InvalidInputError, match="truth has shape"):
        coverage(np.zeros((3, 2, 2)), np.zeros(3), 0.9)
    with pytest.raises(InvalidInputError, match="truth is not finite"):
        coverage(np.zeros((3, 2, 2)), np.full(2, np.nan), 0.9)
    with pytest.raises(InvalidInputError, match="probability is 1.5"):
        normal_interval(np.zeros(2), np.eye(2), 1.5)
