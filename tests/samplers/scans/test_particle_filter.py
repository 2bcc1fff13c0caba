"""The particle filter: Kalman where it is exact, quadrature where it is not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.special import logsumexp

from probreg.errors import InvalidInputError
from probreg.noise import Contaminated, Gaussian, Huber, Hyperbolic, StudentT
from probreg.samplers.scans import ParticleFilter
from tests.motion.test_trajectory import make
from tests.samplers.paths.test_paths import quadrature, short

MIXTURES = [StudentT(3.0), Contaminated(0.2, 8.0), Hyperbolic(0.3)]


def rng(seed=3):
    return np.random.default_rng(seed)


def log_evidence(model, noise, points=141):
    """Of three scans of one state, by quadrature over the path."""
    x, step = np.linspace(-9.0, 13.0, points, retstep=True)
    rows = [noise.log_density((model.y[t, 0] - x)[:, None]) for t in range(3)]
    move = -0.5 * (x[:, None] - x) ** 2 / 0.5 - 0.5 * np.log(2.0 * np.pi * 0.5)
    level = -0.5 * (x / 2.0) ** 2 - 0.5 * np.log(2.0 * np.pi * 4.0) + rows[0]
    for t in (1, 2):
        level = logsumexp(level[:, None] + move, axis=0) + np.log(step) + rows[t]
    return logsumexp(level) + np.log(step)


def test_under_gaussian_noise_it_is_the_kalman_filter():
    model = make(m=4)
    model = dataclasses.replace(model, width=2)
    track = ParticleFilter(Gaussian(), particles=3).track(model, rng())
    exact = model.filter()
    np.testing.assert_allclose(track.mean, exact.mean, atol=1e-9)
    assert track.facts["log_evidence"] == pytest.approx(exact.log_likelihood, rel=1e-10)
    np.testing.assert_allclose(track.facts["effective"], 3.0)


@pytest.mark.parametrize("law", MIXTURES, ids=repr)
def test_evidence_is_unbiased_and_the_mean_that_of_quadrature(law):
    # 40 filters; means of evidence ratio and of the last state in standard errors, limit 4
    model = short()
    tracks = [ParticleFilter(law, particles=800).track(model, rng(s)) for s in range(40)]
    ratio = np.exp([t.facts["log_evidence"] - log_evidence(model, law) for t in tracks])
    last = np.array([t.mean[-1, 0] for t in tracks]) - quadrature(model, law)[0][-1]
    for values in (ratio - 1.0, last):
        assert abs(values.mean()) < 4.0 * values.std(ddof=1) / np.sqrt(40)
        assert values.std() < 0.2
    # negative control: another law's evidence
    wrong = np.exp([t.facts["log_evidence"] - log_evidence(model, Gaussian()) for t in tracks])
    assert abs(wrong.mean() - 1.0) > 4.0 * wrong.std(ddof=1) / np.sqrt(40)


def test_components_not_reported_do_not_count():
    model = make(m=4)
    R = np.tile(np.eye(4), (7, 1, 1))
    present = np.tile([True, True, True, False], (7, 1))
    law = StudentT(3.0)
    gap = dataclasses.replace(model, R=R, present=present, width=2)
    swapped = dataclasses.replace(gap, y=np.where(present, model.y, 99.0))
    one, two = (ParticleFilter(law, 50).track(m, rng()) for m in (gap, swapped))
    np.testing.assert_array_equal(one.mean, two.mean)


def test_intervals_hold_what_the_model_drew():
    # 60 runs of 7 scans, exact binomial limits of the last scan's three states; 1e-3
    from probreg.diagnostics import binomial_limits

    held, law = [], StudentT(4.0, componentwise=True)
    for seed in range(60):
        path, model = make(seed=4).simulate(law, rng(seed))
        low, high = np.moveaxis(
            ParticleFilter(law, 300).track(model, rng(seed)).interval(0.8), 2, 0
        )
        held.append((low[-1] <= path[-1]) & (path[-1] <= high[-1]))
    low, high = binomial_limits(60, 0.8, 1e-3 / 3)
    for share in np.mean(held, axis=0):
        assert low <= share <= high


def test_settings_are_checked():
    for make_it, text in (
        (lambda: ParticleFilter(Huber(1.0)), "Take ScanMetropolis"),
        (lambda: ParticleFilter(particles=1), "at least two"),
        (lambda: ParticleFilter(resample_below=2.0), "not in"),
    ):
        with pytest.raises(InvalidInputError, match=text):
            make_it()


def test_same_seed_same_track():
    one, two = (ParticleFilter(StudentT(3.0), 50).track(make(), rng(1)) for _ in range(2))
    np.testing.assert_array_equal(one.draws, two.draws)
