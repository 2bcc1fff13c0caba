"""Laws as sums of Gaussians, and their parameters by expected counts."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize

from probreg.errors import InvalidInputError
from probreg.noise import Contaminated, Gaussian, Hyperbolic, MixtureCounts, StudentT

LAWS = [
    Gaussian(scale=2.0),
    Contaminated(0.1, 10.0, core_scale=0.8),
    StudentT(0.8),
    StudentT(4.0, scale=3.0),
    StudentT(40.0),
    Hyperbolic(1e-3),
    Hyperbolic(3.0, scale=0.5),
]


def log_mixture(law, v):
    share, variance = law.mixture(v.shape[1])
    d2 = (v**2).sum(axis=1)[:, None]
    parts = -0.5 * d2 / variance - 0.5 * v.shape[1] * np.log(2.0 * np.pi * variance)
    with np.errstate(divide="ignore"):
        parts = parts + np.log(share)
    top = parts.max(axis=1, keepdims=True)
    return (top + np.log(np.exp(parts - top).sum(axis=1, keepdims=True)))[:, 0]


@pytest.mark.parametrize("m", [1, 2, 3])
@pytest.mark.parametrize("law", LAWS, ids=str)
def test_a_law_is_the_sum_of_its_gaussians(law, m):
    v = np.zeros((6, m))
    v[:, 0] = np.array([0.0, 0.3, 1.0, 2.0, 4.0, 8.0]) * law.unit
    np.testing.assert_allclose(log_mixture(law, v), law.log_density(v), atol=4e-3)
    assert law.mixture(m).share.sum() == pytest.approx(1.0)


def test_a_law_with_a_corner_is_no_sum_of_gaussians():
    with pytest.raises(InvalidInputError, match="no sum of Gaussians"):
        Hyperbolic(1e-3, 1.0).mixture(2)


def expectation(law, v):
    """Counts of the law's Gaussians when the noise itself is seen."""
    share, variance = law.mixture(v.shape[1])
    d2 = (v**2).sum(axis=1)[:, None]
    log_p = np.log(share) - 0.5 * d2 / variance - 0.5 * v.shape[1] * np.log(variance)
    p = np.exp(log_p - log_p.max(axis=1, keepdims=True))
    p /= p.sum(axis=1, keepdims=True)
    return MixtureCounts(p.sum(axis=0), v.shape[1] * p.sum(axis=0), (p * d2).sum(axis=0))


def settled(law, v, steps=400):
    for _ in range(steps):
        law = law.refitted(expectation(law, v), v.shape[1], frozenset(law.supports))
    return law


def test_counts_of_contaminated_noise_settle_at_the_highest_posterior():
    v = Contaminated(0.15, 6.0, core_scale=1.3).sample(np.random.default_rng(1), 600, 2)
    start = Contaminated(0.05, 10.0)
    # the prior of the outliers' scale is about where each step starts: held at its end here
    found = settled(start, v)
    wide = found.core_scale * found.scale

    def loss(x):
        rate, core, out = 1.0 / (1.0 + np.exp(-x[0])), np.exp(x[1]), np.exp(x[2])
        fit = Contaminated(rate, out / core, core_scale=core).log_density(v).sum()
        prior = np.log(rate) + 9.0 * np.log1p(-rate)
        for scale, about in ((core, 1.0), (out, wide)):
            prior += -4.0 * np.log(scale) - 2.0 * (about / scale) ** 2
        return -fit - prior

    best = minimize(loss, [-2.0, 0.1, 2.0], method="Nelder-Mead", options={"xatol": 1e-6}).x
    wanted = [1.0 / (1.0 + np.exp(-best[0])), np.exp(best[1]), np.exp(best[2])]
    np.testing.assert_allclose([found.rate, found.core_scale, wide], wanted, rtol=2e-4)


def test_counts_of_student_noise_settle_at_the_highest_posterior():
    v = StudentT(3.0, scale=1.5).sample(np.random.default_rng(2), 500, 2)
    found = settled(StudentT(8.0), v, 300)

    def loss(x):
        nu, scale = np.exp(x)
        prior = 2.0 * x[0] - 0.1 * nu - 4.0 * x[1] - 2.0 * scale**-2
        return -StudentT(nu, scale=scale).log_density(v).sum() - prior

    wanted = np.exp(minimize(loss, [1.0, 0.0], method="Nelder-Mead").x)
    np.testing.assert_allclose([found.nu, found.scale], wanted, rtol=5e-3)


@pytest.mark.parametrize("law", [Gaussian(), Hyperbolic(1e-3)], ids=str)
def test_the_scale_of_other_laws_is_estimated(law):
    true = type(law)(**{"scale": 2.0, **({"mu": 1e-3} if isinstance(law, Hyperbolic) else {})})
    v = true.sample(np.random.default_rng(3), 4_000, 2)
    found = settled(law, v, 60)
    # four standard errors of a scale from 8000 components, widened for the heavy tails
    assert found.scale == pytest.approx(2.0, rel=4.0 * 1.5 / np.sqrt(8_000))


def test_parameters_that_are_known_stay():
    v = StudentT(3.0, scale=1.5).sample(np.random.default_rng(4), 100, 2)
    for law in LAWS:
        assert law.refitted(expectation(law, v), 2, frozenset()) == law


def test_scales_stay_where_nothing_is_said():
    silent = MixtureCounts(np.zeros(2), np.zeros(2), np.zeros(2))
    law = Contaminated(0.1, 10.0)
    again = law.refitted(silent, 2, frozenset(law.supports))
    assert (again.rate, again.core_scale, again.scale) == pytest.approx((0.1, 1.0, 10.0))
    assert stats.beta(1, 9).mean() == pytest.approx(again.rate)
