"""Targets that only bearings see: placed where lines of sight meet, and worth something."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from probreg.errors import InvalidInputError
from probreg.noise import Contaminated
from probreg.posterior.tracks import TrackModel, fit_tracks
from probreg.prior import GaussianPrior
from probreg.problems.recording.first_guess import first_guess
from probreg.problems.recording.sensor_model import SensorModel
from probreg.problems.recording.track_reports import TrackReports
from probreg.sensors.axes import PolarAxes
from tests.problems.test_track_reports import Constant

LIMIT = stats.norm.isf(0.5e-4)  # one false alarm in ten thousand numbers
TRUE = np.array([60.0, 4e-3, -5e-3, 3e-3])


def scene(seed, n=2400, K=16, listeners=(1, 2)):
    """A radar of half of the targets, bearings of all of them; straight flights."""
    rng = np.random.default_rng(seed)
    start, speed = rng.uniform(-60e3, 60e3, (K, 2)), rng.normal(0.0, 120.0, (K, 2))
    start[:, 1] += 80e3
    places = np.array([[0.0, 0.0], [-40e3, 10e3], [45e3, -5e3]])
    axes = [PolarAxes(p, ("azimuth",)) for p in places]
    axes[0] = PolarAxes(places[0], ("range", "azimuth"))
    sigmas = [np.array([40.0, 2e-3]), np.array([4e-3]), np.array([4e-3])]
    terms = [((0, Constant(0)), (1, Constant(1))), ((2, Constant(0)),), ((3, Constant(0)),)]
    models = tuple(SensorModel(*parts) for parts in zip(axes, sigmas, terms, strict=True))
    target, time = rng.integers(0, K, n), rng.uniform(0.0, 300.0, n)
    sensor = rng.integers(0, 3, n)
    deaf = (target >= K // 2) & ~np.isin(sensor, listeners)
    sensor[deaf] = rng.choice(listeners, deaf.sum())
    x = start[target] + time[:, None] * speed[target]
    values = np.full((n, 2), np.nan)
    for k, biases in enumerate((TRUE[:2], TRUE[2:3], TRUE[3:])):
        own = sensor == k
        seen = axes[k].observe(x[own]).value
        noise = rng.normal(size=seen.shape) * sigmas[k]
        values[own, : seen.shape[1]] = seen + biases + noise
    return TrackReports(models, sensor, target, time, values, 4), x


def test_lines_of_sight_meet_near_the_target():
    reports, x = scene(1)
    guess = first_guess(reports)
    away = np.linalg.norm(guess.position - x, axis=1)[reports.target >= 8]
    # half a degree of bias and of noise each, at some 100 km
    assert np.median(away) < 1.5e3
    assert away.max() < 8e3


def test_targets_of_bearings_only_say_something_of_the_bearings():
    z, gain = [], []
    for seed in range(8):
        reports, _ = scene(seed)
        prior = GaussianPrior.from_sd(np.array([100.0, 0.02, 0.02, 0.02]))
        laws = (Contaminated(0.02, 10.0),) * 3
        whole = TrackModel(reports, prior, laws, acceleration=0.01)
        fit = fit_tracks(whole)
        z.append((fit.theta - TRUE) / fit.sd)
        part = fit_tracks(whole.of_targets(np.arange(8)))
        gain.append(fit.sd / part.sd)
    assert np.abs(z).max() < LIMIT
    low, high = stats.chi2(np.size(z)).ppf([5e-4, 1.0 - 5e-4]) / np.size(z)
    assert low < np.mean(np.square(z)) < high
    assert np.mean(gain, axis=0)[2:].max() < 0.97


def test_bearings_of_one_place_place_nothing():
    reports, _ = scene(2, listeners=(1,))
    with pytest.raises(InvalidInputError, match=r"target 8 \(8 in all\).*do not meet"):
        first_guess(reports)
    guess = first_guess(reports, strict=False)
    assert np.isnan(guess.position[reports.target >= 8]).all()
    assert np.isfinite(guess.position[reports.target < 8]).all()


def test_a_platform_that_turns_places_what_it_sees_alone():
    """Bearings of one sensor on the move: own positions of every report."""
    rng = np.random.default_rng(3)
    n = 120
    time = np.sort(rng.uniform(0.0, 400.0, n))
    own = np.column_stack([200.0 * time, 40e3 * np.sin(time / 100.0)])
    x = np.array([60e3, 90e3]) + time[:, None] * np.array([-40.0, 10.0])
    axes = PolarAxes(np.zeros(2), ("azimuth",))
    values = axes.observe(x - own).value + 2e-3 * rng.normal(size=(n, 1))
    model = SensorModel(axes, np.array([2e-3]))
    zeros = np.zeros(n, dtype=int)
    reports = TrackReports((model,), zeros, zeros, time, values, 0, own=own)
    away = np.linalg.norm(first_guess(reports).position - x, axis=1)
    assert away.max() < 3e3
