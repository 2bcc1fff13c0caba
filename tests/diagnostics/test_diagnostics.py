from __future__ import annotations

import numpy as np
import pytest

from probreg import LinearProblem, UnobservableError
from probreg.diagnostics import bias, cramer_rao_bound, rmse
from probreg.errors import ImproperLawError, InvalidInputError
from probreg.estimators import Irls, LeastSquares
from probreg.noise import Contaminated, Gaussian, StudentT, Tukey
from tests.conftest import linear_problem


def test_gaussian_bound_is_the_inverse_normal_matrix():
    problem, theta = linear_problem(1)
    expected = np.zeros((4, 4))
    for B, R in zip(problem.B, problem.R, strict=True):
        expected += B.T @ np.linalg.solve(R, B)
    np.testing.assert_allclose(cramer_rao_bound(problem, theta), np.linalg.inv(expected), rtol=1e-9)
    wide = cramer_rao_bound(problem, theta, Gaussian(scale=3.0))
    np.testing.assert_allclose(wide, 9.0 * np.linalg.inv(expected), rtol=1e-7)


@pytest.mark.parametrize(
    ("law", "m", "expected"),
    [(StudentT(5.0), 1, 6 / 8), (StudentT(5.0), 3, 8 / 10), (Gaussian(), 3, 1.0)],
    ids=repr,
)
def test_information_has_its_closed_form(law, m, expected):
    # (nu + m) / (nu + m + 2) for the multivariate t
    assert law.information_factor(m) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("law", [Gaussian(), StudentT(3.0), Contaminated(0.2, 10.0)], ids=repr)
def test_maximum_likelihood_attains_the_bound(law):
    # 400 runs x 3 parameters; variance ratio at 5 standard errors: false alarm rate 1e-6 a law
    base, theta = linear_problem(2, n=400, p=3)
    bound = np.diag(cramer_rao_bound(base, theta, law))
    root = np.linalg.cholesky(base.R)
    rng = np.random.default_rng(5)
    fits = []
    for _ in range(400):
        # the noise is spherical in whitened coordinates of any root
        noise = (root @ law.sample(rng, 400, 3)[..., None])[..., 0]
        problem = LinearProblem(base.B @ theta + noise, base.B, base.R)
        fits.append(Irls(law).estimate(problem).theta - theta)
    ratio = np.mean(np.square(fits), axis=0) / bound
    assert (np.abs(ratio - 1.0) < 5 * np.sqrt(2 / 400)).all()
    if not isinstance(law, Gaussian):
        # negative control: least squares on the same law does not
        rng = np.random.default_rng(5)
        worse = []
        for _ in range(400):
            noise = (root @ law.sample(rng, 400, 3)[..., None])[..., 0]
            problem = LinearProblem(base.B @ theta + noise, base.B, base.R)
            worse.append(LeastSquares().estimate(problem).theta - theta)
        assert (np.mean(np.square(worse), axis=0) / bound > 1 + 5 * np.sqrt(2 / 400)).all()


def test_bound_of_rows_of_different_length_is_that_of_their_information():
    one, _ = linear_problem(3, n=20, m=2)
    two, theta = linear_problem(4, n=30, m=3)
    pad = LinearProblem(
        np.concatenate([np.pad(one.y, ((0, 0), (0, 1))), two.y]),
        np.concatenate([np.pad(one.B, ((0, 0), (0, 1), (0, 0))), two.B]),
        np.concatenate([np.pad(one.R, ((0, 0), (0, 1), (0, 1))) + np.diag([0, 0, 1.0]), two.R]),
        size=np.repeat([2, 3], [20, 30]),
    )
    law = StudentT(4.0)
    separate = sum(np.linalg.inv(cramer_rao_bound(p, theta, law)) for p in (one, two))
    np.testing.assert_allclose(
        cramer_rao_bound(pad, theta, law), np.linalg.inv(separate), rtol=1e-7
    )


def test_bound_refuses_what_has_none():
    problem, theta = linear_problem(5)
    with pytest.raises(ImproperLawError, match="information"):
        cramer_rao_bound(problem, theta, Tukey())
    blind = LinearProblem(problem.y, problem.B * [1.0, 1.0, 1.0, 0.0], problem.R)
    with pytest.raises(UnobservableError):
        cramer_rao_bound(blind, theta)


def test_bias_and_rmse_with_their_errors():
    # coverage of 95 % intervals over 2000 repetitions: 4 standard errors either way, plus the
    # delta method's own error at 50 runs
    rng = np.random.default_rng(6)
    draws = 0.7 + 2.0 * rng.normal(size=(50, 2000))
    for measure, truth in ((bias(draws, 0.0), 0.7), (rmse(draws, 0.0), np.sqrt(0.49 + 4.0))):
        inside = np.abs(measure.value - truth) < 1.96 * measure.standard_error
        assert abs(inside.mean() - 0.95) < 4 * np.sqrt(0.05 * 0.95 / 2000) + 0.02


def test_monte_carlo_figures_refuse_one_run_and_nan():
    with pytest.raises(InvalidInputError, match="at least two"):
        bias(np.zeros((1, 3)), 0.0)
    with pytest.raises(InvalidInputError, match="run 2"):
        rmse(np.array([0.0, 1.0, np.nan]), 0.0)
