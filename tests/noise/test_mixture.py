"""Laws as sums of Gaussians, and their parameters by expected counts."""

from __future__ import annotations

import numpy as np
import pytest
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
    about = law
    for _ in range(steps):
        law = law.refitted(expectation(law, v), v.shape[1], frozenset(law.supports), about)
    return law


def test_counts_of_contaminated_noise_settle_at_the_highest_posterior():
    v = Contaminated(0.15, 6.0, core_scale=1.3).sample(np.random.default_rng(1), 600, 2)
    start = Contaminated(0.05, 10.0)
    found = settled(start, v)

    def loss(x):
        rate, core, out = 1.0 / (1.0 + np.exp(-x[0])), np.exp(x[1]), np.exp(x[2])
        fit = Contaminated(rate, out / core, core_scale=core).log_density(v).sum()
        prior = 0.5 * np.log(rate) + 9.5 * np.log1p(-rate)
        for scale, about in ((core, 1.0), (out, 10.0)):
            prior += -4.0 * np.log(scale) - 2.0 * (about / scale) ** 2
        return -fit - prior

    best = minimize(loss, [-2.0, 0.1, 2.0], method="Nelder-Mead", options={"xatol": 1e-6}).x
    wanted = [1.0 / (1.0 + np.exp(-best[0])), np.exp(best[1]), np.exp(best[2])]
    wide = found.core_scale * found.scale
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
        assert law.refitted(expectation(law, v), 2, frozenset(), law) == law


def test_parameters_stay_where_nothing_is_said():
    silent = MixtureCounts(np.zeros(2), np.zeros(2), np.zeros(2))
    law = Contaminated(0.2, 7.0, core_scale=1.5)
    again = law.refitted(silent, 2, frozenset(law.supports), law)
    assert (again.rate, again.core_scale, again.scale) == pytest.approx((0.2, 1.5, 7.0))


def gibbs(law, v, rng, draws):
    """Gaussians of the rows and parameters in turn, from noise that is seen."""
    about, kept = law, []
    share_of = np.arange(len(v))
    for _ in range(draws):
        share, variance = law.mixture(v.shape[1])
        d2 = (v**2).sum(axis=1)[:, None]
        log_p = np.log(share) - 0.5 * d2 / variance - 0.5 * v.shape[1] * np.log(variance)
        p = np.cumsum(np.exp(log_p - log_p.max(axis=1, keepdims=True)), axis=1)
        which = (p < rng.random((len(v), 1)) * p[:, -1:]).sum(axis=1)
        one = np.zeros((len(v), len(share)))
        one[share_of, which] = 1.0
        rows = one.sum(axis=0)
        counts = MixtureCounts(rows, v.shape[1] * rows, (one * d2).sum(axis=0))
        law = law.draw_parameters(rng, counts, v.shape[1], frozenset(law.supports), about)
        kept.append(law)
    return kept


def moments_on_a_grid(log_density, axes):
    """Means and standard deviations of a density on a grid."""
    mesh = np.meshgrid(*axes, indexing="ij")
    log_p = np.vectorize(log_density)(*mesh)
    p = np.exp(log_p - log_p.max())
    p /= p.sum()
    mean = [float((p * x).sum()) for x in mesh]
    return mean, [float(np.sqrt((p * (x - m) ** 2).sum())) for x, m in zip(mesh, mean, strict=True)]


def test_draws_of_student_parameters_have_the_moments_of_the_posterior():
    rng = np.random.default_rng(6)
    v = StudentT(3.0).sample(rng, 60, 2)

    def log_density(log_nu, log_scale):
        nu, scale = np.exp(log_nu), np.exp(log_scale)
        prior = 2.0 * log_nu - 0.1 * nu - 4.0 * log_scale - 2.0 * scale**-2
        return StudentT(nu, scale=scale).log_density(v).sum() + prior

    axes = [np.linspace(np.log(0.5), np.log(100.0), 70), np.linspace(-0.8, 0.8, 60)]
    mean, sd = moments_on_a_grid(log_density, axes)
    kept = gibbs(StudentT(5.0), v, rng, 4_000)[100:]
    found = np.log([[law.nu, law.scale] for law in kept])
    # some fifty steps a draw: four standard errors of the means, and of the spreads
    np.testing.assert_allclose((found.mean(axis=0) - mean) / sd, 0.0, atol=4.0 / np.sqrt(80.0))
    np.testing.assert_allclose(found.std(axis=0) / sd, 1.0, atol=4.0 / np.sqrt(160.0))


def test_draws_of_contaminated_parameters_have_the_moments_of_the_posterior():
    rng = np.random.default_rng(7)
    v = Contaminated(0.2, 8.0).sample(rng, 150, 2)

    def log_density(free_rate, log_core, log_wide):
        rate, core, wide = 1.0 / (1.0 + np.exp(-free_rate)), np.exp(log_core), np.exp(log_wide)
        prior = 1.0 * np.log(rate) + 9.0 * np.log1p(-rate)
        prior += -4.0 * log_core - 2.0 * core**-2 - 4.0 * log_wide - 2.0 * (10.0 / wide) ** 2
        return Contaminated(rate, wide / core, core_scale=core).log_density(v).sum() + prior

    axes = [np.linspace(-2.6, -0.4, 22), np.linspace(-0.35, 0.35, 22), np.linspace(1.5, 2.6, 22)]
    mean, sd = moments_on_a_grid(log_density, axes)
    kept = gibbs(Contaminated(0.1, 10.0), v, rng, 1_500)[100:]
    found = np.array(
        [
            [np.log(k.rate / (1 - k.rate)), np.log(k.core_scale), np.log(k.core_scale * k.scale)]
            for k in kept
        ]
    )
    # some five steps a draw
    np.testing.assert_allclose((found.mean(axis=0) - mean) / sd, 0.0, atol=4.0 / np.sqrt(280.0))
    np.testing.assert_allclose(found.std(axis=0) / sd, 1.0, atol=4.0 / np.sqrt(560.0))
