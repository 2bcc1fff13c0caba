"""Pooling of recordings: brute force, limits, calibration."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from probreg.diagnostics import Ranks
from probreg.errors import InvalidInputError
from probreg.registration.hierarchy import pool

MEAN, SD = np.array([3.0, 5.5, -1.0, 4.0]), np.array([0.8, 1.5, 0.5, 2.0])


def rng(seed=1):
    return np.random.default_rng(seed)


def test_moments_are_those_of_brute_force():
    # common and spread on a grid of both; 40 000 independent draws, limit 4.4 of 6 scores
    common, spread = np.linspace(-25.0, 30.0, 1201), np.linspace(1e-3, 20.0, 1200)
    c, s = np.meshgrid(common, spread, indexing="ij")
    height = stats.norm(0.0, 10.0).logpdf(c) + stats.halfnorm(0.0, 4.0).logpdf(s)
    for m, e in zip(MEAN, SD, strict=True):
        height = height + stats.norm(c, np.hypot(e, s)).logpdf(m)
    weight = np.exp(height - height.max())
    weight /= weight.sum()
    first = (MEAN[0] / SD[0] ** 2 + c / s**2) / (1.0 / SD[0] ** 2 + 1.0 / s**2)
    found = pool(MEAN, SD, common_sd=10.0, spread_sd=4.0, num_draws=40_000, rng=rng())
    for draws, exact in ((found.common, c), (found.spread, s), (found.each[:, 0], first)):
        expected = (weight * exact).sum()
        assert abs(draws.mean() - expected) < 4.4 * draws.std() / 200.0
    for draws, exact in ((found.common, c), (found.spread, s)):
        away = (draws - (weight * exact).sum()) ** 2
        expected = (weight * (exact - (weight * exact).sum()) ** 2).sum()
        assert abs(away.mean() - expected) < 4.4 * away.std() / 200.0
    # negative control: recordings taken for one
    plain = np.average(MEAN, weights=SD**-2.0)
    assert abs(found.common.mean() - plain) > 4.4 * found.common.std() / 200.0
    assert found.interval(0.9).shape == (3, 2)


def test_recordings_that_agree_are_pooled_and_those_that_do_not_are_left_alone():
    alike = pool(np.full(6, 2.0), np.full(6, 1.0), common_sd=100.0, spread_sd=0.01,
                 num_draws=4000, rng=rng())  # fmt: skip
    assert alike.each.std(axis=0).max() == pytest.approx(1.0 / np.sqrt(6.0), rel=0.1)
    apart = pool(100.0 * np.arange(6.0), np.full(6, 1.0), common_sd=1e4, spread_sd=1e3,
                 num_draws=4000, rng=rng())  # fmt: skip
    assert apart.each.std(axis=0).min() == pytest.approx(1.0, rel=0.1)
    assert apart.new.std() > 100.0


def test_draws_are_calibrated():
    # truth from the prior, 300 runs, ranks among 49 draws; family-wise 1e-3
    generator, ranks = rng(5), []
    for _ in range(300):
        common, spread = 3.0 * generator.normal(), abs(2.0 * generator.normal())
        each = common + spread * generator.normal(size=4)
        found = pool(each + SD * generator.normal(size=4), SD, common_sd=3.0, spread_sd=2.0,
                     num_draws=49, rng=generator)  # fmt: skip
        ranks.append([
            (found.common < common).sum(), (found.spread < spread).sum(),
            (found.each[:, 1] < each[1]).sum(),
        ])  # fmt: skip
    assert Ranks(np.array(ranks), 49, ("common", "spread", "each")).p_values.min() > 1e-3 / 3


def test_bad_numbers_are_refused():
    good = {"common_sd": 1.0, "spread_sd": 1.0, "num_draws": 5, "rng": rng()}
    with pytest.raises(InvalidInputError, match="one recording says nothing"):
        pool(MEAN[:1], SD[:1], **good)
    with pytest.raises(InvalidInputError, match="sd of recording 2"):
        pool(MEAN, np.array([1.0, 1.0, 0.0, 1.0]), **good)
    with pytest.raises(InvalidInputError, match="spread_sd"):
        pool(MEAN, SD, **{**good, "spread_sd": -1.0})


@pytest.mark.parametrize(("factor", "spread_sd"), [(1.0, 3.0), (1.0, 3000.0), (10.0, 0.01)])
def test_the_spread_is_right_over_decades_of_its_prior(factor, spread_sd):
    # quantiles of 40 000 draws against quadrature on a logarithmic grid of ten decades
    mean, sd = factor * np.array([0.3, 0.5, -0.1, 0.4]), np.array([0.08, 0.15, 0.05, 0.2])
    tau = np.geomspace(1e-6, 1e5, 200_001)
    total = sd**2 + tau[:, None] ** 2
    precision = (1.0 / total).sum(axis=1) + 1e-4
    centre = (mean / total).sum(axis=1) / precision
    height = stats.norm(0.0, np.sqrt(total)).logpdf(mean).sum(axis=1)
    height += 0.5 * centre**2 * precision - 0.5 * np.log(precision) - 0.5 * (tau / spread_sd) ** 2
    weight = np.exp(height - height.max()) * tau
    share = np.cumsum(weight) / weight.sum()
    exact = [tau[np.searchsorted(share, p)] for p in (0.05, 0.5, 0.95)]
    found = pool(mean, sd, common_sd=100.0, spread_sd=spread_sd, num_draws=40_000, rng=rng())
    below = np.array([(found.spread < q).mean() for q in exact])
    np.testing.assert_allclose(below, [0.05, 0.5, 0.95], atol=0.01)
    with pytest.raises(InvalidInputError, match="num_draws"):
        pool(mean, sd, common_sd=1.0, spread_sd=1.0, num_draws=0, rng=rng())
