"""Noise scores against what is usual of each sensor: invariances, moments, rates and delays."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import poisson

from probreg.watch import _usual
from probreg.watch._alarms import Clock, first_alarms, listen_noise
from probreg.watch._usual import fade_of, next_scores, no_scores, noise_threshold, strengths
from probreg.watch._watchdogs import COMPARED, FACTORS, shiryaev_roberts
from probreg.watch.state import Alarms

FADE = fade_of(10.0)
MODELS = 200


def alarmed(ratios, counts, threshold):
    """Alarms (slice, model, factor) of ratios (slices, models, factors), by the rule itself."""
    models = ratios.shape[1]
    alarms = first_alarms(models, models, 2, 4)
    alarms = Alarms(**{**vars(alarms), "thresholds": np.array([np.inf, threshold, np.inf])})
    names, found = tuple(map(str, range(models))), []
    for k, (ratio, n) in enumerate(zip(ratios, counts, strict=True)):
        heard = listen_noise(alarms, (ratio, n), names, Clock(0.0, 10.0, k))
        alarms = heard.alarms
        found += [(k, int(a.sensor), a.size) for a in heard.raised]
    return found


def gaussian(rng, slices, noise=1.0, models=MODELS, hung=0.0):
    """Ratios and counts of reports whose noise is `noise` times what the law has.

    Residuals of neighbouring slices share a part: their squares correlate by about `hung`.
    """
    counts = rng.poisson(60.0, (slices, models))
    square = np.empty((slices, models))
    common = rng.standard_normal(models)
    for k in range(slices):
        common = hung * common + np.sqrt(1.0 - hung**2) * rng.standard_normal(models)
        own = np.sqrt(120.0) * common if hung else 0.0
        square[k] = noise**2 * (rng.chisquare(counts[k]) + own * np.sqrt(counts[k] / 60.0))
    factors = np.array(FACTORS)
    ratio = 0.5 * square[..., None] * (1.0 - factors**-2.0)
    return ratio - counts[..., None] * np.log(factors), counts


def test_the_usual_is_the_mean_and_variance_of_the_scores():
    rng = np.random.default_rng(0)
    ratios, counts = gaussian(rng, _usual.LEARN, models=3)
    scores = no_scores(3, len(FACTORS))
    for ratio, n in zip(ratios, counts, strict=True):
        scores = next_scores(scores, ratio, n, COMPARED, 1.0)
    total, reports = ratios[..., COMPARED].sum(axis=0), counts.sum(axis=0)
    np.testing.assert_allclose(scores.mean, total / reports[:, None])
    np.testing.assert_array_equal(scores.reports, reports)
    away = (ratios[..., COMPARED] - counts[..., None] * scores.mean) / np.sqrt(counts[..., None])
    # Welford: the sum of squares about the last mean
    np.testing.assert_allclose(scores.variance, (away**2).mean(axis=0))
    assert np.isneginf(strengths(scores)).all()


def test_evidence_does_not_depend_on_what_is_usual():
    """A law that does not fit, or reports that hang together, only shift and stretch scores."""
    ratios, counts = gaussian(np.random.default_rng(1), 80, models=4)
    counts[:] = 60
    found = []
    for shift, scale in ((0.0, 1.0), (3.0, 2.5)):
        scores = no_scores(4, len(FACTORS))
        for ratio, n in zip(ratios, counts, strict=True):
            scores = next_scores(scores, shift + scale * ratio, n, COMPARED, FADE)
        found.append(scores.sums)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)


@pytest.mark.parametrize("hung", [0.0, 0.4])
def test_false_alarms_come_as_stated_though_the_law_does_not_fit(hung):
    """Poisson limits that err once in a thousand; reports scatter a tenth more than the law has."""
    rng, slices, rate = np.random.default_rng(2), 400, 2e-4
    threshold = noise_threshold(rate, FADE, np.random.default_rng(0))
    ratios, counts = gaussian(rng, slices, 1.1, hung=hung)
    expected = rate * 2 * MODELS * (slices - _usual.LEARN)
    # scores of a chi square are skewed: that costs a factor of less than two
    assert len(alarmed(ratios, counts, threshold)) <= poisson.ppf(0.999, 2.0 * expected)
    # controls: no threshold, and the sums of the ratios as they are, by the bound that they had
    assert len(alarmed(ratios, counts, 0.0)) > poisson.ppf(0.999, 20.0 * expected)
    total, count = np.full((MODELS, len(FACTORS)), -np.inf), 0
    for ratio in ratios:
        total = shiryaev_roberts(total, 0.5 * ratio)
        loud = (total > -np.log(rate)).any(axis=1)
        total[loud], count = -np.inf, count + int(loud.sum())
    assert count > poisson.ppf(0.999, 2.0 * expected)


def test_more_and_less_noise_are_found_and_their_factor_is_named():
    rng, threshold = np.random.default_rng(3), 10.0
    before, n = gaussian(rng, 60)
    # less noise is a shift of three standard deviations, and may become usual before it is found
    for noise, delay, found_of in ((1.5, 3, 0.97), (0.7, 6, 0.6), (2.0, 2, 0.97)):
        after, m = gaussian(rng, 20, noise)
        found = alarmed(np.concatenate([before, after]), np.concatenate([n, m]), threshold)
        first = {s: (k - 59, factor) for k, s, factor in reversed(found) if k >= 60}
        assert len(first) > found_of * MODELS
        assert np.median([k for k, _ in first.values()]) <= delay
        # two slices: a standard deviation of six per cent, and neighbours on the grid
        assert np.mean([factor == noise for _, factor in first.values()]) > 0.8


def test_one_slice_alone_raises_no_alarm_whatever_is_in_it():
    ratios, counts = gaussian(np.random.default_rng(4), 60, models=5)
    usual = 9.5  # that of one false alarm a day
    ratios[40] += 1e5
    assert alarmed(ratios, counts, usual) == []
    ratios[41] += 1e5
    assert len(alarmed(ratios, counts, usual)) == 5


def test_slices_without_reports_of_a_sensor_change_nothing_of_it():
    ratios, counts = gaussian(np.random.default_rng(5), 40, models=2)
    scores = no_scores(2, len(FACTORS))
    for ratio, n in zip(ratios, counts, strict=True):
        scores = next_scores(scores, ratio, n, COMPARED, FADE)
    none = next_scores(scores, np.zeros_like(ratios[0]), np.array([0, 60]), COMPARED, FADE)
    for name in ("slices", "reports", "mean", "variance", "product", "last", "sums"):
        before, after = getattr(scores, name), getattr(none, name)
        np.testing.assert_array_equal(after[0], before[0], err_msg=name)
        assert (after[1] != before[1]).any(), name


def test_rarer_alarms_have_higher_thresholds():
    found = [noise_threshold(p, FADE, np.random.default_rng(0)) for p in (1e-3, 4e-6)]
    assert found[1] - found[0] > 2.0
    # with all known, the sum passes h at most once in exp(h) slices; overshoot makes that rarer
    assert found[1] < -np.log(4e-6)
