"""Remarks: two reports at one time, biases no prior foresaw, reports that were used."""

from __future__ import annotations

import dataclasses

import numpy as np

from probreg import BearingSensor
from probreg.recordings import Recording
from probreg.registration import register
from tests.registration.conftest import ANGLE, fly, sensors_2d


def doubled(recording, rows):
    """The recording with some reports said twice, the second time 500 m farther."""
    order = np.sort(np.concatenate([np.arange(len(recording)), rows]))
    second = np.r_[False, np.diff(order) == 0]
    values = recording.values[order]
    values[second, 0] += 500.0
    return Recording(
        recording.sensors,
        recording.sensor[order],
        recording.time[order],
        values,
        recording.target[order],
    )


def test_two_reports_at_one_time_are_counted_and_used_reports_too():
    made = fly(sensors_2d(), {"a.range": 30.0})
    rows = np.flatnonzero(made.recording.sensor == 1)[:7]
    found = register(doubled(made.recording, rows), made.setup, rng=np.random.default_rng(1))
    said = [note for note in found.notes if "two reports at one time" in note]
    assert len(said) == 1
    assert said[0].startswith("b gives")
    assert "in 7 cases" in said[0]
    count = np.bincount(found.recording.sensor)
    used = [found.used[s.name] for s in found.recording.sensors]
    believed = np.bincount(found.recording.sensor[found.fit.wrong <= 0.5])
    assert used == believed.tolist()
    assert (np.array(used) >= count - 7).all()
    # the second reports are 500 m off at sigmas of 30 m
    assert len(found.suspects()) == 7
    assert set(found.suspects()["sensor"]) == {"b"}


def test_a_bias_that_no_prior_foresaw_is_remarked_on():
    made = fly(sensors_2d(), {"a.range": 90.0})
    tight = dataclasses.replace(made.setup, prior_sd={"a.range": 10.0})
    for setup, expected in ((made.setup, 0), (tight, 1)):
        notes = register(made.recording, setup, rng=np.random.default_rng(1)).notes
        assert sum("prior standard deviations from zero" in note for note in notes) == expected


def test_long_gaps_lone_reports_and_targets_that_nothing_places_are_remarked():
    made = fly((*sensors_2d()[:2], BearingSensor(ANGLE, "eye")), {"a.range": 30.0}, scans=20)
    recording = made.recording
    target, time = recording.target.copy(), recording.time.copy()
    away = (target == 0) & (time > 40.0)
    time[away] += 1_000.0  # one identity comes back a quarter of an hour later
    lone = np.flatnonzero((target == 1) & (recording.sensor == 0))[0]
    target[lone] = 50
    seen = np.flatnonzero((target == 2) & (recording.sensor == 2))
    target[seen] = 60  # from one fixed place, bearings do not meet
    order = np.argsort(time, kind="stable")
    moved = Recording(
        recording.sensors,
        recording.sensor[order],
        time[order],
        recording.values[order],
        target[order],
        own_position=recording.own_position[order],
    )
    notes = register(moved, made.setup, rng=np.random.default_rng(1)).notes
    said = " ".join(notes)
    assert "1 times an identity was away for more than 300 s" in said
    assert "1 tracks have one report only" in said
    assert f"{len(seen)} reports are of targets that nothing places" in said
    plain = " ".join(register(recording, made.setup, rng=np.random.default_rng(1)).notes)
    assert "an identity was away" not in plain
    assert "nothing places" not in plain
    assert "one report only" not in plain


def test_accuracies_of_the_others_are_told_beside_a_sensor_whose_errors_correlate():
    made = fly(sensors_2d(), {"a.range": 30.0}, targets=30, scans=20)
    found = register(made.recording, made.setup, rng=np.random.default_rng(1))
    assert {one.sensor for one in found.accuracies} == {"a", "b"}
