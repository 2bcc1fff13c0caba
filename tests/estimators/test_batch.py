"""Batch estimators against other libraries and direct minimisation."""

from __future__ import annotations

import numpy as np
import pytest
import statsmodels.api as sm
from scipy.optimize import minimize

from probreg import GaussianPrior, LinearProblem, Posterior, ReportProblem, UnobservableError
from probreg.errors import InvalidInputError
from probreg.estimators import Irls, LeastSquares, Lms
from probreg.noise import Contaminated, Gaussian, HardReject, Huber, Hyperbolic, StudentT, Tukey
from tests.conftest import PAIR_BIAS, linear_problem, polar_reports, radar_pair


def contaminated(seed=1, n=300, m=3):
    """A linear problem in which a tenth of the rows is twenty times noisier."""
    problem, theta = linear_problem(seed, n=n, m=m)
    rng = np.random.default_rng(seed + 100)
    bad = rng.random(n) < 0.1
    y = problem.y + 20.0 * bad[:, None] * rng.normal(size=problem.y.shape)
    return LinearProblem(y, problem.B, problem.R), theta


def stacked(problem):
    """Whitened equations by Cholesky factors, computed here."""
    root = np.linalg.inv(np.linalg.cholesky(problem.R))
    v = np.einsum("nij,nj->ni", root, problem.y)
    return v.ravel(), (root @ problem.B).reshape(v.size, -1)


def test_least_squares_is_lstsq():
    problem, _ = contaminated()
    v, A = stacked(problem)
    estimate = LeastSquares().estimate(problem)
    np.testing.assert_allclose(estimate.theta, np.linalg.lstsq(A, v)[0], rtol=1e-10)
    np.testing.assert_allclose(estimate.covariance, np.linalg.inv(A.T @ A), rtol=1e-10)


def test_least_squares_with_a_prior_is_lstsq_with_its_rows():
    problem, _ = linear_problem(3, n=2, m=2, p=6)
    prior = GaussianPrior(np.arange(6.0), np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
    v, A = stacked(problem)
    root = np.diag(1.0 / np.sqrt(np.arange(1.0, 7.0)))
    expected = np.linalg.lstsq(np.vstack([A, root]), np.concatenate([v, root @ prior.mean]))[0]
    np.testing.assert_allclose(LeastSquares().estimate(problem, prior).theta, expected, rtol=1e-9)


def test_irls_with_huber_is_statsmodels_rlm():
    problem, _ = contaminated(m=1)
    v, A = stacked(problem)
    # the same threshold and a fixed unit scale: the sigmas are the data sheet's
    model = sm.RLM(v, A, M=sm.robust.norms.HuberT(1.345))
    reference = model.fit(scale_est=lambda model, resid: 1.0, tol=1e-12, maxiter=500, conv="coefs")
    estimate = Irls(Huber(1.345)).estimate(problem)
    np.testing.assert_allclose(estimate.theta, reference.params, atol=1e-8)
    np.testing.assert_allclose(estimate.weights, reference.weights, atol=1e-7)


@pytest.mark.parametrize(
    "law",
    [Hyperbolic(1e-3), Hyperbolic(0.5), StudentT(3.0), Contaminated(0.1, 20.0), Huber(1.345),
     Huber(1.345, True), Hyperbolic(1e-3, componentwise=True)],
    ids=repr,
)  # fmt: skip
def test_irls_minimises_the_objective(law):
    problem, _ = contaminated()
    v, A = stacked(problem)

    def objective(theta):
        # equation (9) for the hyperbolic law; whitening by Cholesky, so whole-vector laws only
        return -np.sum(law.log_kernel(law.squared_norm((v - A @ theta).reshape(-1, 3))[0], 3))

    if law.componentwise:
        white = problem.whitened()  # component-wise laws depend on which root is taken

        def objective(theta):
            residual = white.v - white.A @ theta
            return -np.sum(law.log_kernel(residual**2, 1))

    estimate = Irls(law).estimate(problem)
    best = objective(estimate.theta)
    for method in ("BFGS", "Nelder-Mead"):
        options = {"gtol": 1e-10} if method == "BFGS" else {"xatol": 1e-9, "fatol": 1e-11}
        options["maxiter"] = 20_000
        found = minimize(objective, estimate.theta + 0.01, method=method, options=options)
        assert best <= found.fun + 1e-7
        np.testing.assert_allclose(found.x, estimate.theta, atol=2e-4)


def test_lad_objective_is_the_papers_equation_9():
    problem, _ = contaminated()
    mu = 1e-3
    estimate = Irls(Hyperbolic(mu)).estimate(problem)

    def equation_9(b):
        e = problem.y - problem.B @ b
        d2 = np.einsum("ni,nij,nj->n", e, np.linalg.inv(problem.R), e)
        return np.sqrt(d2 + mu**2).sum()

    found = minimize(equation_9, np.zeros(4), method="BFGS", options={"gtol": 1e-8})
    assert equation_9(estimate.theta) <= found.fun + 1e-8
    np.testing.assert_allclose(estimate.theta, found.x, atol=1e-4)


def test_sandwich_covariance_is_statsmodels_hc0_for_least_squares():
    problem, _ = contaminated(m=1)
    v, A = stacked(problem)
    reference = sm.OLS(v, A).fit().get_robustcov_results("HC0").cov_params()
    estimate = Irls(Gaussian()).estimate(problem)
    np.testing.assert_allclose(estimate.covariance, reference, rtol=1e-8)


SANDWICHED = [
    Gaussian(), Huber(), StudentT(4.0), Contaminated(), Hyperbolic(), Hyperbolic(1e-3, 1.345),
    Hyperbolic(componentwise=True), Huber(1.345, True),
]  # fmt: skip


def standardised(law, claimed, m=3, runs=400):
    """Errors over claimed standard deviations, with a tenth of the rows contaminated."""
    scores = []
    for seed in range(runs):
        problem, theta = contaminated(seed, n=360 // m, m=m)
        estimate = Irls(law).estimate(problem)
        scores.append((estimate.theta - theta) / claimed(estimate))
    return np.array(scores)


@pytest.mark.parametrize("m", [1, 3])
@pytest.mark.parametrize("law", SANDWICHED, ids=repr)
def test_sandwich_is_the_spread_of_the_estimate(law, m):
    # 400 runs; the mean of 4 variance ratios has a standard error of 3.5 % (more if they are
    # correlated): limits of 18 % are beyond 4 of them, plus 4 % for 360 equations
    spread = np.mean(standardised(law, lambda e: e.sd, m) ** 2)
    assert abs(spread - 1.0) < 0.18


def test_trusting_the_law_fails_that_test():
    # negative control: least squares with R taken at its word
    spread = np.mean(
        standardised(Gaussian(), lambda e: np.sqrt(np.diag(e.info["laplace_covariance"]))) ** 2
    )
    assert spread > 5.0


def test_a_prior_counts_as_an_observation():
    # where the data say nothing the prior's own uncertainty remains
    problem, _ = linear_problem(3, n=200)
    B = problem.B * [1.0, 1.0, 1.0, 0.0]
    prior = GaussianPrior.from_sd(np.full(4, 10.0))
    blind = LinearProblem(problem.y, B, problem.R)
    for law in (Gaussian(), StudentT(4.0), Huber()):
        estimate = Irls(law).estimate(blind, prior)
        assert estimate.sd[3] == pytest.approx(10.0)
        assert (estimate.sd[:3] < 1.0).all()


def test_a_start_that_takes_no_prior_is_not_given_one():
    problem, theta = contaminated()
    prior = GaussianPrior.from_sd(np.full(4, 100.0))
    estimate = Irls(Tukey(), start=Lms()).estimate(problem, prior, np.random.default_rng(0))
    assert (np.abs(estimate.theta - theta) < 5 * estimate.sd).all()


def test_a_class_is_not_a_law():
    problem, _ = linear_problem(3)
    for make in (lambda: Irls(Huber).estimate(problem), lambda: Irls("huber").estimate(problem)):
        with pytest.raises(InvalidInputError, match="pass a law"):
            make()


def test_laplace_covariance_is_the_inverse_hessian_by_finite_differences():
    problem, _ = contaminated()
    posterior = Posterior(problem, StudentT(4.0), GaussianPrior(np.zeros(4), 9.0 * np.eye(4)))
    mode = posterior.mode()
    h = 1e-4
    hessian = np.empty((4, 4))
    for k in range(4):
        step = h * np.eye(4)[k]
        hessian[k] = -(
            posterior.grad_log_prob(mode.theta + step) - posterior.grad_log_prob(mode.theta - step)
        ) / (2 * h)
    np.testing.assert_allclose(
        posterior.laplace_covariance(mode), np.linalg.inv(hessian), rtol=1e-5, atol=1e-9
    )


def test_relinearised_estimate_is_stationary():
    problem = ReportProblem(polar_reports(radar_pair(), PAIR_BIAS, seed=12, n=400))
    estimate = Irls(StudentT(4.0)).estimate(problem)
    linear = problem.linearise(estimate.theta)
    again = Irls(StudentT(4.0)).estimate(linear)
    scale = estimate.sd
    np.testing.assert_allclose(again.theta / scale, estimate.theta / scale, atol=1e-4)
    assert estimate.info["relinearisations"] > 1


def test_redescending_laws_start_from_least_absolute_deviation():
    problem, theta = contaminated()
    far = LinearProblem(problem.y + 500.0 * (np.arange(300)[:, None] < 60), problem.B, problem.R)
    good = Irls(Tukey()).estimate(far)
    assert np.abs(good.theta - theta).max() < 0.5
    started = Irls(Tukey(), start=Lms(subsets=500)).estimate(far, rng=np.random.default_rng(0))
    np.testing.assert_allclose(started.theta, good.theta, atol=1e-6)


def test_rejecting_everything_is_an_error_with_a_remedy():
    problem, _ = linear_problem(2)
    with pytest.raises(UnobservableError, match="rejects too much"):
        Posterior(problem, HardReject(0.01)).mode(start=np.full(4, 1e6))


def test_lms_finds_the_exact_fit_of_the_majority():
    problem, theta = linear_problem(4, n=60, noise=0.0)
    y = problem.y.copy()
    y[:24] += 50.0  # 40 % of the rows shifted the same way
    spoiled = LinearProblem(y, problem.B, problem.R)
    for unit in ("row", "equation"):
        estimate = Lms(unit).estimate(spoiled, rng=np.random.default_rng(1))
        np.testing.assert_allclose(estimate.theta, theta, atol=1e-8)
        np.testing.assert_array_equal(estimate.weights.reshape(60, -1)[:24], 0.0)
    assert np.abs(LeastSquares().estimate(spoiled).theta - theta).max() > 0.3


def test_lms_tries_all_subsets_when_they_are_few():
    problem, _ = contaminated(n=15)
    few = Lms(subsets=200).estimate(problem)  # 105 pairs of rows: no generator needed
    for seed in range(3):
        drawn = Lms(subsets=60).estimate(problem, rng=np.random.default_rng(seed))
        assert few.info["median"] <= drawn.info["median"] + 1e-12


def test_lms_median_is_that_of_the_raw_solution():
    problem, _ = contaminated(n=101)
    estimate = Lms(subsets=300).estimate(problem, rng=np.random.default_rng(3))
    e = problem.y - problem.B @ estimate.info["raw"]
    d2 = np.einsum("ni,nij,nj->n", e, np.linalg.inv(problem.R), e)
    assert estimate.info["median"] == pytest.approx(np.median(d2))
    scale2 = np.median(d2) / 2.366 * (1 + 5 / (101 - 4)) ** 2
    assert estimate.info["scale"] ** 2 == pytest.approx(scale2, rel=1e-4)
    np.testing.assert_array_equal(estimate.weights > 0, d2 < 9.348 * scale2)


def test_lms_scale_is_right_for_rows_of_different_length():
    # scale of 400 clean rows: its standard error is about 6 %
    one, theta = linear_problem(5, n=200, m=3)
    two, _ = linear_problem(6, n=200, m=1)
    rng = np.random.default_rng(0)
    y = two.B @ theta + np.sqrt(two.R[:, :, 0]) * rng.normal(size=(200, 1))
    wide = LinearProblem(
        np.concatenate([one.y, np.pad(y, ((0, 0), (0, 2)))]),
        np.concatenate([one.B, np.pad(two.B, ((0, 0), (0, 2), (0, 0)))]),
        np.concatenate([one.R, np.pad(two.R, ((0, 0), (0, 2), (0, 2))) + np.diag([0.0, 1.0, 1.0])]),
        size=np.repeat([3, 1], 200),
    )
    estimate = Lms(subsets=2000).estimate(wide, rng=rng)
    assert estimate.info["scale"] == pytest.approx(1.0, abs=0.2)
    for rows in (slice(200), slice(200, None)):
        assert abs(estimate.weights[rows].mean() - 0.975) < 0.03


def test_lms_needs_a_generator_for_random_subsets():
    problem, _ = linear_problem(4)
    with pytest.raises(InvalidInputError, match="pass a Generator"):
        Lms().estimate(problem)


def test_lms_takes_no_prior_and_no_unknown_unit():
    problem, _ = linear_problem(4)
    with pytest.raises(InvalidInputError, match="takes no prior"):
        Lms().estimate(problem, GaussianPrior(np.zeros(4), np.eye(4)))
    with pytest.raises(InvalidInputError, match="'row' or 'equation'"):
        Lms("column")
    for bad in (0, 2.5):
        with pytest.raises(InvalidInputError, match="subsets"):
            Lms(subsets=bad)
