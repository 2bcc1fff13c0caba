from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import sqrtm

from probreg import GaussianPrior, LinearProblem, Posterior, UnobservableError
from probreg.errors import ImproperLawError, InvalidInputError
from probreg.noise import Gaussian, StudentT, Tukey
from tests.conftest import linear_problem


@pytest.mark.parametrize("m", [1, 2, 3, 5])
def test_whitening_is_by_the_symmetric_root(m):
    problem, _ = linear_problem(2, n=12, m=m)
    white = problem.whitened()
    for k in range(12):
        root = np.linalg.inv(np.real(sqrtm(problem.R[k])))
        np.testing.assert_allclose(white.v[k], root @ problem.y[k], rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(white.A[k], root @ problem.B[k], rtol=1e-9, atol=1e-12)
        assert white.log_det[k] == pytest.approx(np.linalg.slogdet(problem.R[k])[1])


def test_whitening_of_nearly_singular_and_diagonal_covariances():
    R = np.stack(
        [
            np.diag([1e-8, 1.0, 1e8]),
            np.eye(3) + 1e-12,
            [[1, 0.999999, 0], [0.999999, 1, 0], [0, 0, 4]],
        ]
    )
    problem = LinearProblem(np.ones((3, 3)), np.ones((3, 3, 1)), R)
    white = problem.whitened()
    for k in range(3):
        vectors = np.linalg.solve(np.linalg.cholesky(R[k]), problem.y[k])
        assert np.sum(white.v[k] ** 2) == pytest.approx(np.sum(vectors**2), rel=1e-6)


def test_residual_and_jacobian_of_the_linear_problem():
    problem, theta = linear_problem(3)
    np.testing.assert_allclose(problem.residual(theta), problem.y - problem.B @ theta)
    np.testing.assert_array_equal(problem.jacobian(theta), -problem.B)
    assert problem.linearise(theta) is problem
    many = problem.whitened().residual(np.stack([theta, 2 * theta]))
    np.testing.assert_allclose(many[1], problem.whitened().residual(2 * theta))


def broken(**changes):
    problem, _ = linear_problem(4, n=10)
    fields = {"y": problem.y, "B": problem.B, "R": problem.R}
    return lambda: LinearProblem(**{**fields, **changes})


def with_value(array, index, value):
    array = array.copy()
    array[index] = value
    return array


BASE = linear_problem(4, n=10).problem


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (broken(y=with_value(BASE.y, (3, 1), np.nan)), r"y\[3, 1\] is nan"),
        (broken(B=with_value(BASE.B, (9, 0, 2), np.inf)), r"B\[9, 0, 2\] is inf"),
        (broken(R=with_value(BASE.R, 6, -np.eye(3))), r"R\[6\] is not positive definite"),
        (broken(R=with_value(BASE.R, 2, np.zeros((3, 3)))), r"R\[2\] is not positive definite"),
        (broken(R=with_value(BASE.R, (5, 0, 1), 99.0)), r"R\[5\] is not symmetric"),
        (broken(y=BASE.y[:4]), r"B has shape \(10, 3, 4\); expected \(4, 3, any\)"),
        (broken(R=BASE.R[:, :2, :2]), "R has shape"),
        (broken(y=BASE.y[:0], B=BASE.B[:0], R=BASE.R[:0]), "no target was seen in common"),
        (broken(names=("a", "b")), "4 unknowns need 4 different names"),
        (broken(names=("a", "a", "b", "c")), "4 unknowns need 4 different names"),
        (broken(time=np.arange(3.0)), "time has shape"),
        (broken(size=np.zeros(10, int)), "1 to 3 real components"),
        (broken(size=np.full(10, 2.7)), "1 to 3 real components"),
        (broken(size=np.full(10, 2)), "row 0 is padded with numbers that count"),
        (broken(y="text"), "y must be an array of numbers"),
    ],
)
def test_bad_input_is_named(make, message):
    with pytest.raises(InvalidInputError, match=message):
        make()


def test_a_covariance_at_the_edge_of_double_precision_is_named():
    # passes Cholesky, has no positive smallest eigenvalue: found by search
    edge = np.array(
        [
            [1.8672224328678517, 1.2345589547768572, -1.2595039609703695],
            [1.2345589547768572, 0.8162584926932814, -0.8327516544687491],
            [-1.2595039609703695, -0.8327516544687491, 0.8495782220298587],
        ]
    )
    problem = LinearProblem(BASE.y, BASE.B, with_value(BASE.R, 4, edge))
    with pytest.raises(InvalidInputError, match=r"R\[4\] is numerically singular"):
        problem.whitened()


def test_unobservable_combinations_are_named():
    problem, _ = linear_problem(5, n=40)
    B = problem.B.copy()
    B[..., 3] = 2.0 * B[..., 1]  # moving x by -2 and w by 1 changes nothing
    hidden = LinearProblem(problem.y, B, problem.R, names=("v", "x", "y", "w"))
    report = hidden.observability()
    assert not report.complete
    assert report.combinations() in (["x - 0.5 w"], ["-0.5 w + x"], ["-2 x + w"])
    np.testing.assert_allclose(hidden.B @ report.null_space[0], 0.0, atol=1e-9)
    assert problem.observability().complete
    values = np.linalg.svd(
        problem.whitened().A.reshape(-1, 4)
        / np.linalg.norm(problem.whitened().A.reshape(-1, 4), axis=0),
        compute_uv=False,
    )
    np.testing.assert_allclose(problem.observability().singular_values, values)


def test_a_prior_makes_an_unobservable_problem_solvable():
    problem, _ = linear_problem(6, n=1, m=2, p=4)
    with pytest.raises(UnobservableError, match="2 equations for 4 unknowns"):
        Posterior(problem, Gaussian())
    posterior = Posterior(problem, Gaussian(), GaussianPrior(np.zeros(4), np.eye(4)))
    assert np.isfinite(posterior.mode().theta).all()


def test_a_column_of_zeros_is_unobservable():
    problem, _ = linear_problem(7)
    B = with_value(problem.B, (..., 2), 0.0)
    with pytest.raises(UnobservableError, match=r"Moving along theta\[2\] changes"):
        Posterior(LinearProblem(problem.y, B, problem.R), Gaussian())


class TestPosterior:
    problem, theta = linear_problem(8)
    prior = GaussianPrior(np.full(4, 0.2), np.diag([1.0, 2.0, 0.5, 3.0]))

    def test_gaussian_posterior_is_the_closed_form(self):
        posterior = Posterior(self.problem, Gaussian(), self.prior)
        n = self.problem.y.size
        B = self.problem.B.reshape(n, 4)
        R = np.zeros((n, n))
        for k, block in enumerate(self.problem.R):
            R[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = block
        precision = B.T @ np.linalg.solve(R, B) + np.linalg.inv(self.prior.covariance)
        right = B.T @ np.linalg.solve(R, self.problem.y.ravel())
        mean = np.linalg.solve(
            precision, right + np.linalg.solve(self.prior.covariance, self.prior.mean)
        )
        mode = posterior.mode()
        np.testing.assert_allclose(mode.theta, mean, rtol=1e-9)
        np.testing.assert_allclose(
            posterior.laplace_covariance(mode), np.linalg.inv(precision), rtol=1e-9
        )
        from scipy.stats import multivariate_normal as normal

        joint = normal(B @ self.theta, R).logpdf(self.problem.y.ravel()) + normal(
            self.prior.mean, self.prior.covariance
        ).logpdf(self.theta)
        assert posterior.log_prob(self.theta) == pytest.approx(joint)

    def test_log_prob_is_the_sum_of_its_rows_for_any_number_of_chains(self):
        posterior = Posterior(self.problem, StudentT(4.0), self.prior)
        thetas = np.random.default_rng(0).normal(size=(3, 5, 4))
        rows = posterior.log_likelihood(thetas)
        assert rows.shape == (3, 5, 60)
        expected = rows.sum(-1) + self.prior.log_density(thetas)
        np.testing.assert_allclose(posterior.log_prob(thetas), expected)
        assert posterior.log_prob(thetas[0, 0]).shape == ()

    @pytest.mark.parametrize("law", [Gaussian(), StudentT(4.0), StudentT(4.0, componentwise=True)])
    def test_gradient_by_finite_differences(self, law):
        posterior = Posterior(self.problem, law, self.prior)
        thetas = np.random.default_rng(1).normal(size=(2, 4))
        steps = 1e-5 * np.eye(4)
        numeric = np.stack(
            [
                (posterior.log_prob(thetas + s) - posterior.log_prob(thetas - s)) / 2e-5
                for s in steps
            ],
            axis=-1,
        )
        np.testing.assert_allclose(posterior.grad_log_prob(thetas), numeric, rtol=1e-6, atol=1e-5)

    def test_row_blocks_change_nothing(self, monkeypatch):
        posterior = Posterior(self.problem, StudentT(4.0), self.prior)
        thetas = np.random.default_rng(2).normal(size=(7, 4))
        whole, slope = posterior.log_prob(thetas), posterior.grad_log_prob(thetas)
        monkeypatch.setattr("probreg.posterior._blocks._CHUNK", 50)
        np.testing.assert_allclose(posterior.log_prob(thetas), whole)
        np.testing.assert_allclose(posterior.grad_log_prob(thetas), slope)

    def test_an_improper_law_has_a_mode_but_no_density(self):
        posterior = Posterior(self.problem, Tukey(), self.prior)
        assert posterior.mode().converged
        with pytest.raises(ImproperLawError, match="Tukey"):
            posterior.log_prob(self.theta)

    def test_bad_priors_and_starts(self):
        with pytest.raises(InvalidInputError, match=r"theta has shape \(3,\)"):
            Posterior(self.problem, Gaussian()).log_prob(np.zeros(3))
        with pytest.raises(InvalidInputError, match="prior sd"):
            GaussianPrior.from_sd(np.array([1.0, -1.0]))
        with pytest.raises(InvalidInputError, match="prior mean has shape"):
            GaussianPrior.from_sd(np.ones(4), np.zeros(3))
        with pytest.raises(InvalidInputError, match="3 entries, the problem 4 unknowns"):
            Posterior(self.problem, Gaussian(), GaussianPrior(np.zeros(3), np.eye(3)))
        with pytest.raises(InvalidInputError, match="prior covariance"):
            GaussianPrior(np.zeros(2), -np.eye(2))
        with pytest.raises(InvalidInputError, match="start has shape"):
            Posterior(self.problem, Gaussian()).mode(start=np.zeros(2))
