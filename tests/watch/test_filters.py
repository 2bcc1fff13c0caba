"""Filters of walking biases, and odds of changes, against dense Gaussian algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from probreg.prior import GaussianPrior
from probreg.watch import WatchSettings, _filters
from probreg.watch._calibration import change_threshold, steady
from probreg.watch._changes import (
    SIZES,
    Slice,
    evidence,
    kinds_of,
    log_odds,
    most_probable,
    next_changes,
    no_changes,
)

P, WINDOW, SLICES = 2, 3, 6
PRIOR_SD = np.array([2.0, 0.5])
SETTINGS = WatchSettings(slice_s=10.0, lag_s=20.0, window=WINDOW, delay_s=0.0)


def slices(seed, count=SLICES):
    """J and eta of slices about the last knots of a window."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        root = rng.normal(size=(P * WINDOW, 4)) / np.repeat(PRIOR_SD, 1)[0]
        found.append((root @ root.T, 3.0 * root @ rng.normal(size=4)))
    return found


def followed(given):
    """Filters after all slices, evidence taken after each."""
    filters = _filters.first_filters(GaussianPrior.from_sd(PRIOR_SD), np.zeros(P), SETTINGS)
    variance = _filters.levels(SETTINGS, PRIOR_SD)
    for J, eta in given:
        filters = _filters.next_knot(filters, variance)
        found = _filters.belief(filters, J, eta, P)
        filters = _filters.with_reports(_filters.weighed(filters, found.log_evidence), J, eta)
    return filters, found


def dense(given, steps):
    """Mean, covariance of all knots and log evidence: prior covariance written out.

    `steps` (knots - 1, P) are variances.
    """
    knots = WINDOW + len(given)
    size = knots * P
    C = np.zeros((size, size))
    for i in range(knots):
        for j in range(knots):
            own = PRIOR_SD**2 + steps[: min(i, j)].sum(axis=0)
            C[i * P : (i + 1) * P, j * P : (j + 1) * P] = np.diag(own)
    J, eta = np.zeros((size, size)), np.zeros(size)
    for k, (part, shift) in enumerate(given):
        rows = slice((k + 1) * P, (k + 1 + WINDOW) * P)
        J[rows, rows] += part
        eta[rows] += shift
    posterior = np.linalg.inv(np.linalg.inv(C) + J)
    log = 0.5 * eta @ posterior @ eta - 0.5 * np.linalg.slogdet(np.eye(size) + C @ J)[1]
    return posterior @ eta, posterior, log


@pytest.mark.parametrize("count", [3, 8])
def test_a_filter_is_the_dense_posterior_of_its_walk(count, monkeypatch):
    given = slices(0, count)
    variance = np.full((1, P), 0.01) * PRIOR_SD**2
    monkeypatch.setattr(_filters, "levels", lambda settings, sd: variance)
    filters, found = followed(given)
    steps = np.repeat(variance, WINDOW - 1 + len(given), axis=0)
    mean, covariance, log = dense(given, steps)
    np.testing.assert_allclose(found.mean[0], mean[-P:], rtol=1e-8)
    np.testing.assert_allclose(found.variance[0], np.diag(covariance)[-P:], rtol=1e-8)
    assert found.log_evidence[0] == pytest.approx(log, rel=1e-7)
    whole = _filters.whole_belief(filters, np.zeros((6, 6)), np.zeros(6))
    np.testing.assert_allclose(whole[0], mean[-P * WINDOW :], rtol=1e-7)


def by_dense_algebra(given):
    """Log evidence of filters 0 to P L: every share of a walk by dense marginal likelihoods."""
    variance = _filters.levels(SETTINGS, PRIOR_SD)
    L = len(variance)
    prior = np.append(0.5, np.full(L - 1, 0.5 / (L - 1)))
    logs, steps = np.zeros(1 + P * L), [[] for _ in range(1 + P * L)]
    for k in range(1 - WINDOW, len(given)):
        odds = np.exp(logs[1:] - logs[1:].max()).reshape(P, L) * prior
        usual = np.einsum("pl,lp->p", odds / odds.sum(axis=1, keepdims=True), variance)
        for f, own in enumerate(steps):
            own.append(usual.copy())
            if f:
                c, level = divmod(f - 1, L)
                own[-1][c] = variance[level, c]
        if k >= 0:
            logs = np.array([dense(given[: k + 1], np.array(own))[2] for own in steps])
    return logs


def test_evidence_of_every_level_is_its_dense_marginal_likelihood():
    given = slices(1)
    _, found = followed(given)
    logs = by_dense_algebra(given)
    np.testing.assert_allclose(found.log_evidence[:-1], logs, atol=1e-6)
    # levels differ by far more: any other order of them would be seen
    assert np.abs(np.diff(np.sort(logs[1:]))).max() > 0.1
    assert np.abs(found.log_evidence[1:-1] - logs[:0:-1]).max() > 0.1


def test_moving_the_origin_changes_nothing():
    filters, _ = followed(slices(2))
    variance = _filters.levels(SETTINGS, PRIOR_SD)
    away = np.array([0.3, -0.2])
    J, eta = slices(3, 1)[0]
    here = _filters.belief(_filters.next_knot(filters, variance), J, eta, P)
    there = _filters.moved(_filters.next_knot(filters, variance), away)
    found = _filters.belief(there, J, eta - J @ np.tile(away, WINDOW), P)
    np.testing.assert_allclose(found.mean + away, here.mean, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.variance, here.variance, rtol=1e-6)
    # the slice's own constant is the same for all filters
    gain = found.log_evidence - here.log_evidence
    np.testing.assert_allclose(gain, gain[0], atol=1e-6)


def test_the_step_after_a_widened_one_is_free_as_well_and_the_one_after_that_is_not():
    filters, _ = followed(slices(4))
    variance = _filters.levels(SETTINGS, PRIOR_SD)
    usual = _filters.next_knot(filters, variance).step[:, -1]
    free = _filters.widened(filters, WINDOW - 1, np.array([100.0, 0.0]))
    after = _filters.next_knot(free, variance)
    extra = after.step[:, -1] - usual
    most = variance.max(axis=0)
    assert (extra[:, 0] > 19.9).all()
    assert (extra[:, 0] <= 0.2 * (100.0 + most[0])).all()
    np.testing.assert_array_equal(extra[:, 1], 0.0)
    last = _filters.next_knot(after, variance)
    np.testing.assert_array_equal(last.step[:, -1], usual)


def test_a_widened_step_frees_later_knots_of_one_bias_and_keeps_the_evidence():
    filters, before = followed(slices(4))
    free = _filters.widened(filters, WINDOW - 1, np.array([100.0, 0.0]))
    found = _filters.belief(free, np.zeros((6, 6)), np.zeros(6), P)
    assert (found.variance[:, 0] > 10.0 * before.variance[:, 0]).all()
    kept = _filters.as_before(free, found.log_evidence, 1)
    again = _filters.belief(kept, np.zeros((6, 6)), np.zeros(6), P)
    np.testing.assert_allclose(again.log_evidence, filters.past[-1], atol=1e-8)


def scored(given, steps, kind, stop=None):
    """Changes after all slices, and the belief by which they were judged, kept by hand."""
    changes = no_changes(P, P * WINDOW)
    covariance = np.kron(np.ones((WINDOW, WINDOW)), np.diag(PRIOR_SD**2))
    mean = np.zeros(P * WINDOW)
    keep = np.r_[P : P * WINDOW, P * WINDOW - P : P * WINDOW]
    for k, (J, eta) in enumerate(given):
        mean, covariance = mean[keep], covariance[np.ix_(keep, keep)]
        covariance[-P:, -P:] += np.diag(steps)
        gain = np.linalg.solve(np.eye(len(J)) + covariance @ J, covariance)
        mean, covariance = mean + gain @ (eta - J @ mean), gain
        changes = next_changes(changes, Slice(J, eta - J @ mean, covariance), k, kind)
    return changes


@pytest.mark.parametrize("which", [0, 1])
def test_odds_of_a_change_are_ratios_of_dense_marginal_likelihoods(which):
    given = slices(5)
    steps = 0.01 * PRIOR_SD**2
    kind = kinds_of(10.0, PRIOR_SD)[which]._replace(every=1)
    odds = log_odds(scored(given, steps, kind), kind.scale)
    knots = WINDOW + len(given)
    grown = np.repeat(steps[None], knots - 1, axis=0)
    grown[: WINDOW - 1] = 0.0
    C = np.zeros((knots * P, knots * P))
    for i in range(knots):
        for j in range(knots):
            own = PRIOR_SD**2 + grown[: min(i, j)].sum(axis=0)
            C[i * P : (i + 1) * P, j * P : (j + 1) * P] = np.diag(own)
    J, eta = np.zeros_like(C), np.zeros(len(C))
    for k, (part, shift) in enumerate(given):
        rows = slice((k + 1) * P, (k + 1 + WINDOW) * P)
        J[rows, rows] += part
        eta[rows] += shift
    for h in range(len(given)):
        for c in range(P):
            for s, size in enumerate(SIZES):
                pattern = np.zeros(len(C))
                for k in range(h, len(given)):
                    place = (WINDOW + k) * P + c
                    pattern[place] = 1.0 if which == 0 else 10.0 * (k - h + 1)
                more = (kind.scale[c] * size) ** 2 * np.outer(pattern, pattern)
                ratio = log_marginal(C + more, J, eta) - log_marginal(C, J, eta)
                assert odds[h, c, s] == pytest.approx(ratio, abs=1e-6)


def log_marginal(C, J, eta):
    """Of biases of covariance C, up to what does not depend on it."""
    size = len(C)
    inner = np.linalg.solve(np.eye(size) + C @ J, C)
    return 0.5 * eta @ inner @ eta - 0.5 * np.linalg.slogdet(np.eye(size) + C @ J)[1]


def test_the_marginal_is_that_of_scipy():
    """The oracle's own check: full-rank observations of the biases."""
    rng = np.random.default_rng(7)
    C, noise = np.diag([1.0, 2.0]), np.diag([0.5, 0.1])
    y = rng.normal(size=2)
    J = np.linalg.inv(noise)
    whole = multivariate_normal(np.zeros(2), C + noise).logpdf(y)
    none = multivariate_normal(np.zeros(2), noise).logpdf(y)
    assert log_marginal(C, J, J @ y) == pytest.approx(whole - none)


def test_a_large_step_is_found_where_it_is():
    kind = kinds_of(10.0, PRIOR_SD)[0]
    rng = np.random.default_rng(8)
    J = np.kron(np.diag([0.0, 0.0, 1.0]), np.diag(100.0 / PRIOR_SD**2))
    given = []
    for k in range(30):
        bias = np.array([0.0, 0.5 if k >= 22 else 0.0])
        z = np.concatenate([np.zeros(4), bias])
        given.append((J, J @ z + np.sqrt(np.diag(J)) * rng.normal(size=6)))
    changes = scored(given, 1e-9 * PRIOR_SD**2, kind)
    found = most_probable(changes, log_odds(changes, kind.scale), kind.scale)
    assert (found.begun, found.term) == (22, 1)
    assert abs(found.size - 0.5) < 4.0 * found.sd
    assert found.sd < 0.05


def test_rarer_false_alarms_have_higher_thresholds_and_come_as_stated():
    J = np.kron(np.diag([0.0, 0.0, 1.0]), np.diag(25.0 / PRIOR_SD**2))
    variance = 1e-8 * PRIOR_SD**2
    covariance = steady(J, variance, PRIOR_SD**2, 360)
    kinds = kinds_of(10.0, PRIOR_SD)
    rates = (8.0, 0.32)
    found = [
        change_threshold(J, covariance, kinds, (rate, 360.0), np.random.default_rng(0))
        for rate in rates
    ]
    assert found[1] - found[0] == pytest.approx(np.log(rates[0] / rates[1]), abs=1.0)
    counts = [alarms_in(J, covariance, kinds, limit, hours=7.5) for limit in (found[0], 0.0)]
    # Poisson of mean 60 lies in here but once in 5000 times; the calibration itself has 7 per cent
    assert 30 < counts[0] < 98
    assert counts[1] > 150  # a threshold of one is no threshold


def alarms_in(J, covariance, kinds, limit, hours):
    """Of slices that say what they should: counted by the rule itself, slice by slice."""
    rng = np.random.default_rng(1)
    spread = J - J @ covariance @ J
    values, vectors = np.linalg.eigh(spread)
    root = vectors * np.sqrt(np.clip(values, 0.0, None))
    changes = [no_changes(P, P * WINDOW)] * 2
    count = 0
    for number in range(round(hours * 360)):
        now = Slice(J, root @ rng.standard_normal(P * WINDOW), covariance)
        changes = [next_changes(c, now, number, k) for c, k in zip(changes, kinds, strict=True)]
        odds = tuple(log_odds(c, k.scale) for c, k in zip(changes, kinds, strict=True))
        if evidence(odds) > limit:
            count += 1
            changes = [no_changes(P, P * WINDOW)] * 2
    return count


def test_one_level_is_one_filter():
    settings = replace(SETTINGS, drift=False)
    prior = GaussianPrior.from_sd(PRIOR_SD)
    filters = _filters.first_filters(prior, np.zeros(P), settings)
    assert len(filters.log_scale) == 1
    assert _filters.shares(filters, 1).tolist() == [[1.0]] * P
