"""Alarms of a watch over simulated traffic that changes, and of one that does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from probreg.watch import Alarm, WatchSettings, begin
from probreg.watch._watchdogs import quieter, shiryaev_roberts
from tests.watch.watched import DIRTY, cut, draw, up_to, watched

CHANGES_S, ENDS_S = 300.0, 380.0


@pytest.fixture(scope="module")
def scene():
    recording, setup, truth = draw(1, reports=9_000, **DIRTY)
    settings = WatchSettings()
    state = begin(up_to(recording, 100.0), setup, settings, np.random.default_rng(0))
    return recording, state, truth


def run(scene, recording):
    """Alarms as (seconds after the change, alarm), and the last result."""
    given, state, _ = scene
    start = given.time[0]
    _, results = watched(recording, state, start + ENDS_S)
    found = [(r.time - start - CHANGES_S, alarm) for r in results for alarm in r.alarms]
    return found, results


def changed(recording):
    return (recording.sensor == 1) & (recording.time > recording.time[0] + CHANGES_S)


def test_nothing_happens_if_nothing_does(scene):
    found, results = run(scene, scene[0])
    assert found == []
    # half before any report; minutes say little of slow walks
    assert results[-1].constant.mean() > 0.5


def test_a_step_is_named_placed_and_followed(scene):
    recording, _, truth = scene
    values, step = recording.values.copy(), np.deg2rad(1.0)
    values[changed(recording), 1] += step
    found, results = run(scene, replace(recording, values=values))
    after, alarm = found[0]
    assert 0.0 < after < 30.0
    assert (alarm.kind, alarm.sensor, alarm.term) == ("step", "radar2", "azimuth")
    assert abs(alarm.time - recording.time[0] - CHANGES_S) <= 10.0
    assert abs(alarm.size - step) < 2.5 * alarm.sd
    assert alarm.sd < 0.7 * step
    c = results[0].names.index("radar2.azimuth")
    right = truth.bias["radar2.azimuth"] + step
    at = [r for r in results if r.time > recording.time[0] + CHANGES_S + 30.0]
    assert abs(np.rad2deg(at[0].mean[c] - right)) < 0.05


def test_a_silent_sensor_is_named_within_two_slices(scene):
    recording = scene[0]
    found, _ = run(scene, cut(recording, ~changed(recording)))
    silent = [(after, alarm) for after, alarm in found if alarm.kind == "silence"]
    assert [alarm.sensor for _, alarm in silent] == ["radar2"]
    assert silent[0][0] <= 21.0


def test_noise_that_grows_is_named(scene):
    recording = scene[0]
    own, values = changed(recording), recording.values.copy()
    more = np.sqrt(2.0**2 - 1.0) * recording.sensors[1].sigmas
    values[own, :2] += more * np.random.default_rng(2).standard_normal((own.sum(), 2))
    found, _ = run(scene, replace(recording, values=values))
    assert {(alarm.kind, alarm.sensor) for _, alarm in found} == {("noise", "radar2")}
    assert found[0][0] <= 41.0


def test_counts_as_usual_speak_against_silence_whatever_the_traffic():
    expected = np.array([0.5, 0.3, 0.2])
    for total in (10, 1000):
        assert (quieter((total * expected).astype(int), expected) < 0.0).all()
    assert (quieter(np.zeros(3, dtype=int), expected) == 0.0).all()
    assert quieter(np.array([50, 30, 0]), expected)[2] > 10.0


def test_shiryaev_roberts_is_its_recursion():
    ratio = np.random.default_rng(0).normal(size=20)
    total, found = 0.0, np.array(-np.inf)
    for x in ratio:
        total = (1.0 + total) * np.exp(x)
        found = shiryaev_roberts(found, np.array(x))
    assert np.exp(found) == pytest.approx(total)


def test_alarms_are_plain_in_json(scene):
    _, results = run(scene, cut(scene[0], ~changed(scene[0])))
    alarms = [a for r in results for a in r.to_json()["alarms"]]
    assert {type(value) for a in alarms for value in a.values()} <= {str, float, type(None)}
    silence = next(a for a in alarms if a["kind"] == "silence")
    assert silence["size"] is None
    assert isinstance(Alarm(**{**silence, "size": np.nan, "sd": np.nan}), Alarm)
