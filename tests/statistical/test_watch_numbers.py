"""A watch at length: against batch fits, walking biases, false alarms, delays.

`make test-slow`. Limits are those stated for the watch; Poisson limits err once in a thousand.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import poisson

from probreg.watch import WatchSettings, advance, begin, to_arrays
from probreg.watch._alarms import Clock, first_alarms, listen_changes
from probreg.watch._begin import with_thresholds
from probreg.watch._changes import Slice
from tests.watch.watched import DIRTY, batch, begun, draw, in_slices, up_to, watched

pytestmark = pytest.mark.slow
START_S = 300.0
CONSTANT = WatchSettings(drift=False, floor=1e-5)
WALK_DEG = 0.02  # a root minute


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_constants_with_outliers_and_wrong_pairs_are_those_of_the_batch(seed):
    recording, setup, _ = draw(seed, reports=7_900, **DIRTY)
    state = begun(recording, setup, CONSTANT, START_S, dirty=True)
    state, _ = watched(recording, state)
    _, fit = batch(up_to(recording, state.time - recording.time[0]), setup, dirty=True)
    away = (state.mean - fit.theta) / fit.sd
    assert np.sqrt(np.mean(away**2)) < 0.05
    np.testing.assert_allclose(state.sd / fit.sd, 1.0, atol=0.002)


def walking(recording, seed):
    """Every azimuth walks after the first minutes; the walk (seconds, 3), in radians."""
    rng = np.random.default_rng(seed)
    time = np.arange(recording.time[0] - 1.0, recording.time[-1] + 2.0)
    steps = np.deg2rad(WALK_DEG) * np.sqrt(1.0 / 60.0) * rng.standard_normal((len(time), 3))
    steps[time < recording.time[0] + START_S] = 0.0
    walk, values = np.cumsum(steps, axis=0), recording.values.copy()
    for s in range(3):
        own = recording.sensor == s
        values[own, 1] += np.interp(recording.time[own], time, walk[:, s])
    return replace(recording, values=values), time, walk


def test_a_walk_is_followed_and_a_constant_fit_is_not():
    errors, covered, fixed = [], [], []
    for seed in (1, 2, 3):
        recording, setup, truth = draw(seed, reports=40_000, **DIRTY)
        recording, time, walk = walking(recording, [seed, 1])
        for settings in (WatchSettings(), CONSTANT):
            state = begun(recording, setup, settings, START_S, dirty=True)
            _, results = watched(recording, state)
            bias = np.array([truth.bias[f"radar{s + 1}.azimuth"] for s in range(3)])
            late = [r for r in results if r.time > recording.time[0] + 2.0 * START_S]
            # the belief is about the end of the slice, its reports are of the middle
            middle = np.array([[np.interp(r.time - 5.0, time, w) for w in walk.T] for r in late])
            end = np.array([[np.interp(r.time, time, w) for w in walk.T] for r in late])
            mean = np.array([r.mean[1::2] for r in late])
            sd = np.array([r.sd[1::2] for r in late])
            if settings is CONSTANT:
                fixed.append(np.rad2deg(mean - bias - middle))
            else:
                errors.append(np.rad2deg(mean - bias - middle))
                covered.append(np.abs((mean - bias - end) / sd) < 1.645)
    rms = [float(np.sqrt(np.mean(np.concatenate(e) ** 2))) for e in (errors, fixed)]
    assert rms[0] < 0.0112
    assert rms[1] > 3.0 * rms[0]
    assert 0.82 < np.mean(np.concatenate(covered)) < 0.95


@pytest.fixture(scope="module")
def installed():
    """A watch of 40 aircraft that has begun, and what its last whole slice says."""
    recording, setup, _ = draw(1, reports=8_000, **DIRTY)
    return begin(recording, setup, WatchSettings(), np.random.default_rng(0))


def test_false_alarms_come_as_stated_and_more_often_below_the_threshold(installed):
    rate = 24.0
    state = with_thresholds(
        replace(installed, settings=replace(installed.settings, false_alarms_per_day=rate)),
        np.random.default_rng(1),
    )
    hours, counts = 60, []
    for lower in (0.0, 2.0):
        alarms = replace(first_alarms(3, 3, 6, 48), thresholds=state.alarms.thresholds - lower)
        counts.append(changes_in(state, alarms, hours))
    expected = 0.6 * rate / 24.0 * hours
    # the calibration itself counts some hundred alarms: a tenth more on either side
    low, high = poisson.ppf(5e-4, 0.8 * expected), poisson.ppf(1 - 5e-4, 1.2 * expected)
    assert low <= counts[0] <= high
    assert counts[1] > high


def changes_in(state, alarms, hours):
    """Alarms over slices that say what they should, by the rule itself."""
    rng = np.random.default_rng(2)
    C = 48
    scale = np.tile(np.array([15.0, np.deg2rad(0.022)] * 3), 8)
    J = np.diag(np.where(np.arange(C) >= C - 6, 1.0 / scale**2, 0.0))
    posterior = np.diag(scale**2 / 360.0)
    spread = np.diag(J - J @ posterior @ J)
    count = 0
    for number in range(hours * 360):
        surprise = np.sqrt(spread) * rng.standard_normal(C)
        heard = listen_changes(
            alarms, Slice(J, surprise, posterior), Clock(0.0, 10.0, number), state.scene.bias
        )
        alarms = heard.alarms
        count += len(heard.raised)
    return count


@pytest.mark.parametrize(("size", "limit_s"), [(0.05, 60.0), (0.1, 20.0), (0.2, 20.0)])
def test_steps_are_found_soon(size, limit_s):
    delays = []
    for seed in range(5):
        recording, setup, _ = draw(10 + seed, reports=18_000, **DIRTY)
        change = recording.time[0] + 600.0
        values = recording.values.copy()
        own = (recording.sensor == 1) & (recording.time > change)
        values[own, 1] += np.deg2rad(size)
        given = replace(recording, values=values)
        rng = np.random.default_rng(seed)
        state = begin(up_to(given, START_S), setup, WatchSettings(), rng)
        _, results = watched(given, state, change + 180.0)
        found = [r.time - change for r in results for a in r.alarms if a.sensor == "radar2"]
        delays.append(min([d for d in found if d > 0.0], default=np.inf))
    assert np.median(delays) <= limit_s


def test_sound_noise_raises_no_more_alarms_than_stated_and_more_noise_is_found_soon():
    """Twenty recordings of 20 minutes, and five whose second radar becomes half as noisy again."""
    alarms, hours, delays = 0, 0.0, []
    for seed in range(25):
        louder = seed >= 20
        recording, setup, _ = draw(100 + seed, reports=18_000 if louder else 27_000, **DIRTY)
        change, values = recording.time[0] + 600.0, recording.values.copy()
        rng = np.random.default_rng(seed)
        if louder:
            own = (recording.sensor == 1) & (recording.time > change)
            more = np.sqrt(1.5**2 - 1.0) * recording.sensors[1].sigmas
            values[own, :2] += more * rng.standard_normal((own.sum(), 2))
        state = begin(up_to(recording, START_S), setup, WatchSettings(), rng)
        _, results = watched(replace(recording, values=values), state)
        noise = [
            (r.time - change, a.sensor) for r in results for a in r.alarms if a.kind == "noise"
        ]
        if louder:
            delays.append(min([d for d, s in noise if s == "radar2" and d > 0.0], default=np.inf))
        else:
            alarms, hours = alarms + len(noise), hours + len(results) / 360.0
    assert alarms <= poisson.ppf(0.999, 0.2 * hours / 24.0)  # a fifth of one a day
    assert np.median(delays) <= 30.0


def test_sizes_of_steps_are_as_far_off_as_they_say():
    new, old = [], []
    for seed in range(4):
        recording, setup, _ = draw(40 + seed, reports=9_000, **DIRTY)
        start = begin(up_to(recording, 200.0), setup, WatchSettings(), np.random.default_rng(0))
        rng = np.random.default_rng(seed)
        for step in np.deg2rad([1.0, 0.3, 0.1]):
            change = recording.time[0] + 300.0 + rng.uniform(0.0, 10.0)
            values = recording.values.copy()
            values[(recording.sensor == 1) & (recording.time > change), 1] += step
            state, found = start, []
            for reports, until in in_slices(replace(recording, values=values), start, change + 40):
                before, (state, result) = state, advance(state, reports, until)
                own = [a for a in result.alarms if a.kind == "step" and a.sensor == "radar2"]
                found += own
                if own:
                    c = result.names.index("radar2.azimuth")
                    old.append((own[0].size - step) / np.hypot(state.sd[c], before.sd[c]))
            assert len(found) == 1  # a second one would take back what the first was too large
            new.append((found[0].size - step) / found[0].sd)
    assert np.sqrt(np.mean(np.square(new))) < 2.0
    # the control: beliefs after and before know nothing of the moment within the slice
    assert np.sqrt(np.mean(np.square(old))) > 4.0


def test_memory_stays_bounded():
    recording, setup, _ = draw(5, reports=40_000, **DIRTY)
    state = begun(recording, setup, WatchSettings(), START_S, dirty=True)
    sizes = []
    for reports, until in in_slices(recording, state):
        state, _ = advance(state, reports, until)
        sizes.append(sum(array.nbytes for array in to_arrays(state).values()))
    half = len(sizes) // 2
    assert max(sizes[half:]) < 1.1 * max(sizes[:half]) + 1e6
