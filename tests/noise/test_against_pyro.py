"""Densities against the distributions of an independent package."""

from __future__ import annotations

import numpy as np
import pyro.distributions as dist
import pytest
import torch
from scipy import stats

from probreg.noise import Contaminated, Gaussian, Huber, Hyperbolic, StudentT

V = np.random.default_rng(0).normal(size=(40, 3)) * 3.0


def as_tensor(x):
    return torch.as_tensor(x, dtype=torch.float64)


def test_gaussian():
    expected = dist.Normal(as_tensor(0.0), as_tensor(2.0)).log_prob(as_tensor(V)).sum(-1)
    np.testing.assert_allclose(Gaussian(scale=2.0).log_density(V), expected.numpy())


@pytest.mark.parametrize("nu", [1.0, 3.0, 30.0])
def test_student_t(nu):
    law = dist.MultivariateStudentT(
        as_tensor(nu), torch.zeros(3, dtype=torch.float64), 1.5 * torch.eye(3, dtype=torch.float64)
    )
    expected = law.log_prob(as_tensor(V)).numpy()
    np.testing.assert_allclose(StudentT(nu, scale=1.5).log_density(V), expected)
    apart = dist.StudentT(as_tensor(nu), as_tensor(0.0), as_tensor(1.5)).log_prob(as_tensor(V))
    got = StudentT(nu, scale=1.5, componentwise=True).log_density(V)
    np.testing.assert_allclose(got, apart.sum(-1).numpy())


def test_contaminated():
    narrow = dist.Normal(as_tensor(0.0), as_tensor(1.0)).log_prob(as_tensor(V)).sum(-1)
    wide = dist.Normal(as_tensor(0.0), as_tensor(7.0)).log_prob(as_tensor(V)).sum(-1)
    rates = torch.log(as_tensor([0.8, 0.2]))
    expected = torch.logaddexp(rates[0] + narrow, rates[1] + wide)
    law = Contaminated(0.2, 7.0)
    np.testing.assert_allclose(law.log_density(V), expected.numpy())
    outlier = torch.exp(rates[1] + wide - expected).numpy()
    np.testing.assert_allclose(law.outlier_probability(V), outlier, atol=1e-12)


def test_laplace_is_the_limit_of_the_componentwise_hyperbolic():
    expected = dist.Laplace(as_tensor(0.0), as_tensor(1.0)).log_prob(as_tensor(V)).sum(-1)
    law = Hyperbolic(1e-7, componentwise=True)
    np.testing.assert_allclose(law.log_density(V), expected.numpy(), atol=1e-6)


def test_hyperbolic_against_scipy_in_one_dimension():
    x = V[:, :1]
    expected = stats.genhyperbolic.logpdf(x[:, 0], 1.0, 0.8, 0.0, scale=0.8)
    np.testing.assert_allclose(Hyperbolic(0.8).log_density(x), expected)


def test_huber_with_a_far_threshold_is_gaussian():
    np.testing.assert_allclose(Huber(40.0).log_density(V), Gaussian().log_density(V))
