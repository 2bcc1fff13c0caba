"""Results read back, compared with each other and pooled over days."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from probreg.errors import InvalidInputError
from probreg.registration import days, saved
from probreg.registration.days import pool_days, read_days
from probreg.registration.differences import CHANGES, compare

NAMES = ("a.range", "a.azimuth")
PRIOR = np.array([100.0, np.deg2rad(1.0)])


def write(
    folder, mean, covariance, names=NAMES, units=("m", "rad"), limits=(None, None), start=None
):
    folder.mkdir(parents=True)
    sd = np.sqrt(np.diag(covariance))
    share = 1.0 - (sd / PRIOR) ** 2
    rows = [
        {"name": n, "unit": u, "mean": m, "sd": s, "determined_by_data": d, "limit": limit}
        for n, u, m, s, d, limit in zip(names, units, mean, sd, share, limits, strict=True)
    ]
    text = json.dumps({"biases": rows, "covariance": np.asarray(covariance).tolist()})
    (folder / "biases.json").write_text(text)
    if start is not None:
        pd.DataFrame({"target": [1, 1], "time": [start + 5.0, start]}).to_parquet(
            folder / "tracks.parquet"
        )
    return folder


COVARIANCE = np.array([[4.0, 2e-4], [2e-4, 1e-6]])


def pair(tmp_path, **more):
    old = write(tmp_path / "old", [10.0, 0.002], COVARIANCE)
    new = write(tmp_path / "new", [16.0, 0.001], 2.0 * COVARIANCE, **more)
    return saved.read(old), saved.read(new)


def test_a_difference_is_that_of_independent_normal_biases(tmp_path):
    old, new = pair(tmp_path)
    found = compare(old, new, {"range": 5.0})
    rng = np.random.default_rng(4)
    draws = rng.multivariate_normal(new.mean, new.covariance, 400_000)
    draws -= rng.multivariate_normal(old.mean, old.covariance, 400_000)
    np.testing.assert_allclose(found.mean, draws.mean(axis=0), atol=4.5 * found.sd.max() / 632)
    np.testing.assert_allclose(found.sd, draws.std(axis=0), rtol=0.006)
    ends = np.quantile(draws, [0.05, 0.95], axis=0).T
    np.testing.assert_allclose(found.interval(0.9), ends, atol=0.01 * found.sd.max())
    assert found.exceeds[0] == pytest.approx((np.abs(draws[:, 0]) > 5.0).mean(), abs=0.004)
    assert np.isnan(found.exceeds[1])
    # the joint test by whitening with another factor
    root = np.linalg.cholesky(np.linalg.inv(3.0 * COVARIANCE))
    assert found.chi2 == pytest.approx(((found.mean @ root) ** 2).sum())
    assert found.p_value == pytest.approx(np.exp(-0.5 * found.chi2))  # two degrees of freedom


def test_the_probability_of_a_change_is_that_of_brute_force(tmp_path):
    old, new = pair(tmp_path)
    found = compare(old, new)
    for k, unit in enumerate(("m", "rad")):
        true = np.linspace(-8.0, 8.0, 40_001)[None] * np.array(CHANGES[unit])[:, None]
        weight = stats.norm.pdf(true, 0.0, np.array(CHANGES[unit])[:, None])
        changed = np.trapezoid(weight * stats.norm.pdf(found.mean[k], true, found.sd[k]), true)
        same = stats.norm.pdf(found.mean[k], 0.0, found.sd[k])
        odds = changed.mean() / same
        assert found.differs[k] == pytest.approx(odds / (1.0 + odds), rel=1e-6)


def result(mean, covariance):
    sd = np.sqrt(np.diag(covariance))
    none = np.full(2, np.nan)
    return saved.SavedResult(
        "x", NAMES, ("m", "rad"), mean, sd, covariance, np.ones(2), none, np.nan
    )


def test_it_is_calibrated_where_changes_are_as_assumed():
    # 3000 pairs, half of them changed; of those said to differ with about p, a share p does:
    # squared scores summed over ten bins, below their .999 quantile; and not so with a
    # covariance that is half of the true one
    rng = np.random.default_rng(7)
    true = np.arange(3000) % 2
    said = {1.0: [], 0.5: []}
    for changed in true:
        step = changed * rng.choice(CHANGES["m"]) * rng.normal()
        base = rng.normal(0.0, 5.0, 2)
        means = [
            base + np.array([move, 0.0]) + rng.multivariate_normal(np.zeros(2), COVARIANCE)
            for move in (0.0, step)
        ]
        for factor, found in said.items():
            pair_ = (result(mean, factor * COVARIANCE) for mean in means)
            found.append(compare(*pair_).differs[0])

    def score(said):
        parts = np.array_split(np.argsort(said), 10)
        off = [true[part].sum() - said[part].sum() for part in parts]
        spread = [(said[part] * (1.0 - said[part])).sum() for part in parts]
        return (np.square(off) / np.maximum(spread, 0.05)).sum()

    limit = stats.chi2.ppf(0.999, 10)
    assert score(np.array(said[1.0])) < limit < score(np.array(said[0.5]))


def test_limits_come_from_the_setup_unless_others_are_given(tmp_path):
    old, new = pair(tmp_path, limits=(20.0, None))
    np.testing.assert_array_equal(compare(old, new).limits, [20.0, np.nan])
    found = compare(old, new, {"a.azimuth": 0.01, "range": 1.0}).limits
    np.testing.assert_array_equal(found, [1.0, 0.01])
    with pytest.raises(InvalidInputError, match="no bias 'tilt' to limit; there are a.range"):
        compare(old, new, {"tilt": 1.0})


def test_other_sensors_and_what_is_no_result_are_refused(tmp_path):
    old, _ = pair(tmp_path)
    other = saved.read(
        write(tmp_path / "other", [1.0, 0.0], COVARIANCE, names=("a.range", "b.azimuth"))
    )
    with pytest.raises(InvalidInputError, match=r"other lacks a\.azimuth and has b\.azimuth more"):
        compare(old, other)
    unit = saved.read(write(tmp_path / "unit", [1.0, 0.0], COVARIANCE, units=("m", "m")))
    with pytest.raises(InvalidInputError, match=r"a\.azimuth is in rad in old, and in m in unit"):
        compare(old, unit)
    with pytest.raises(InvalidInputError, match="biases.json cannot be read"):
        saved.read(tmp_path)
    (tmp_path / "biases.json").write_text("{}")
    with pytest.raises(InvalidInputError, match="is no biases.json"):
        saved.read(tmp_path)
    # another order is the same sensors
    same = saved.read(
        write(tmp_path / "same", [0.002, 10.0], COVARIANCE[::-1, ::-1], NAMES[::-1], ("rad", "m"))
    )
    np.testing.assert_array_equal(compare(old, same).mean, [0.0, 0.0])


def test_days_are_in_order_of_time_and_pooled_without_their_priors(tmp_path):
    rng = np.random.default_rng(3)
    for name, start in (("b", 0.0), ("a", 86_400.0), ("c", 172_800.0)):
        write(tmp_path / name, [10.0 + rng.normal(), 0.002], COVARIANCE, start=1.7e9 + start)
    results = read_days(tmp_path)
    assert [result.name for result in results] == ["b", "a", "c"]
    found = pool_days(results, np.random.default_rng(1))
    np.testing.assert_array_equal(found.times, 1.7e9 + 86_400.0 * np.arange(3))
    assert found.prior_sd == pytest.approx(PRIOR)
    # against the pooling of what the data alone say
    data = 1.0 / (1.0 / 4.0 - 1.0 / 100.0**2)
    means = np.array([result.mean[0] for result in results]) * data / 4.0
    wanted = days.pool(
        means, np.full(3, np.sqrt(data)), common_sd=100.0, spread_sd=25.0, num_draws=days.DRAWS,
        rng=np.random.default_rng(1),
    )  # fmt: skip
    np.testing.assert_allclose(found.pooled[0].common, wanted.common, rtol=1e-6)


def test_days_that_say_nothing_are_left_out(tmp_path):
    weak = np.diag([4.0, 0.99 * PRIOR[1] ** 2])
    for name in "abc":
        write(tmp_path / name, [10.0, 0.0], weak)
    found = pool_days(read_days(tmp_path), np.random.default_rng(1))
    assert found.pooled[0] is not None
    assert found.pooled[1] is None
    np.testing.assert_array_equal(found.times, [1.0, 2.0, 3.0])


def test_too_few_days_are_refused(tmp_path):
    write(tmp_path / "in" / "a", [10.0, 0.0], COVARIANCE)
    with pytest.raises(InvalidInputError, match="in holds 1 folders with a biases.json"):
        read_days(tmp_path / "in")
    with pytest.raises(InvalidInputError, match="is no folder"):
        read_days(tmp_path / "nowhere")
