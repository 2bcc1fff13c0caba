"""Identities found, against the truth of simulated traffic."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import PositionSensor
from probreg.association import associate
from probreg.errors import InvalidInputError
from probreg.recordings import UNKNOWN, Recording, Setup
from probreg.registration import register
from probreg.scenarios.traffic import TrafficScene, radars, simulate
from probreg.sensors import Height
from tests.problems.test_recording import SEEN, with_bearings
from tests.registration.conftest import fly, sensors_2d, sensors_3d

BIASES = {
    "radar1.range": 80.0,
    "radar1.azimuth": 0.01,
    "radar2.azimuth": -0.008,
    "radar3.range": -120.0,
}
GNSS = PositionSensor(((400.0, 0.0), (0.0, 400.0)), "gnss")


def unlabelled(recording, rows):
    return dataclasses.replace(recording, target=np.where(rows, UNKNOWN, recording.target))


def purity(found, true):
    """Share of reports whose identity is mostly of their own true target."""
    known = found >= 0
    pairs, count = np.unique(np.stack([found[known], true[known]]), axis=1, return_counts=True)
    most = np.zeros(found.max() + 1)
    np.maximum.at(most, pairs[0], count)
    return most.sum() / known.sum()


def test_reports_find_the_targets_of_a_reference():
    sensors = (*radars(), GNSS)
    scene = TrafficScene(3_000, sensors, (4.0, 5.0, 6.0, 5.0), biases=BIASES)
    recording, setup, truth = simulate(scene, np.random.default_rng(3))
    blind = unlabelled(recording, recording.sensor < 3)
    found = associate(blind, setup)
    own = recording.sensor < 3
    linked = own & (found.target != UNKNOWN)
    assert linked.sum() > 0.9 * own.sum()
    assert (found.target[linked] == truth.target[linked]).mean() > 0.99
    np.testing.assert_array_equal(found.target[~own], recording.target[~own])


def test_without_any_identity_tracks_are_linked_and_matched():
    scene = TrafficScene(6_000, biases=BIASES)
    recording, setup, truth = simulate(scene, np.random.default_rng(3))
    blind = unlabelled(recording, np.ones(len(recording), dtype=bool))
    found = associate(blind, setup)
    assert (found.target != UNKNOWN).mean() > 0.9
    assert purity(found.target, truth.target) > 0.98
    # identities join sensors: without that each target would have three
    assert len(np.unique(found.target)) < 1.7 * len(np.unique(truth.target))


def test_bearings_are_given_to_targets_that_others_place():
    made = fly(with_bearings(), SEEN, gate_m=500.0)
    eye = made.recording.sensor == 1
    found = associate(unlabelled(made.recording, eye), made.setup)
    linked = eye & (found.target != UNKNOWN)
    assert linked.sum() > 0.7 * eye.sum()
    assert (found.target[linked] == made.recording.target[linked]).mean() > 0.95


def test_targets_faster_than_the_setup_allows_are_said_to_be_so():
    made = fly(sensors_2d(), {"a.range": 5.0}, noise=0.1, gate_m=200.0)
    slow = dataclasses.replace(made.setup, max_speed_m_s=30.0)
    speed = np.linalg.norm(made.paths[1], axis=1)
    assert (speed > 60.0).mean() > 0.5
    for setup, said in ((made.setup, 0), (slow, 1)):
        notes = register(made.recording, setup, rng=np.random.default_rng(1)).notes
        assert sum("are of targets faster than max_speed_m_s" in note for note in notes) == said


def test_nothing_near_is_said():
    scene = TrafficScene(300, (*radars(), GNSS), (4.0, 5.0, 6.0, 5.0), biases=BIASES)
    recording, setup, _ = simulate(scene, np.random.default_rng(3))
    silent = unlabelled(recording, np.ones(len(recording), dtype=bool))
    with pytest.raises(InvalidInputError, match="no report could be associated within gate_m"):
        associate(silent, dataclasses.replace(setup, gate_m=1e-6))


LONE = 4  # other aircraft, far from the two and from each other


def stacked(apart_m, *, heights=False):
    """Aircraft 0 and 1 one above the other, seen by two radars; heights may come with plots."""
    radars_3d = sensors_3d()
    sensors = (*radars_3d, Height(30.0)) if heights else radars_3d
    parts = []
    for k, radar in enumerate(radars_3d):
        for target in range(2 + LONE):
            time = 0.7 * target + 5.0 * np.arange(12.0) + (k == 0)
            at = np.outer(time, [150.0, 80.0, 0.0])
            at += np.array([20e3 - 15e3 * max(target - 1, 0), -30e3, 4e3 + apart_m * (target == 1)])
            for t, x, row in zip(time, at, radar.to_report(at), strict=True):
                parts.append((t, k, target, row))
                if heights and k == 0:
                    parts.append((t, 2, target, [x[2], np.nan, np.nan]))
    parts.sort(key=lambda part: part[:2])  # a height follows its plot
    time, sensor, target, values = (np.array(column) for column in zip(*parts, strict=True))
    own = np.arange(len(parts))
    recording = Recording(
        sensors,
        sensor,
        time,
        values,
        target,
        tuple("abcdef"),
        beside=np.where(sensor == 2, own - 1, own),
    )
    return recording, Setup(sensors, {"a": ("range",)})


@pytest.mark.parametrize(("apart_m", "pure"), [(4_000.0, True), (100.0, False)])
def test_aircraft_one_above_the_other_are_two(apart_m, pure):
    recording, setup = stacked(apart_m)
    found = associate(unlabelled(recording, np.ones(len(recording), dtype=bool)), setup)
    assert (found.target != UNKNOWN).mean() > 0.95
    assert (purity(found.target, recording.target) == 1.0) == pure


def test_reports_that_came_together_have_one_identity():
    recording, setup = stacked(4_000.0, heights=True)
    assert (recording.sensor == 2).sum() == 12 * (2 + LONE)
    np.testing.assert_array_equal(recording.target, recording.target[recording.beside])
    found = associate(unlabelled(recording, recording.sensor != 1), setup)
    known = found.target != UNKNOWN
    assert known.mean() > 0.9  # the last reports are beyond those of the second radar
    np.testing.assert_array_equal(found.target[known], recording.target[known])
    np.testing.assert_array_equal(found.target, found.target[recording.beside])
    blind = associate(unlabelled(recording, np.ones(len(recording), dtype=bool)), setup)
    np.testing.assert_array_equal(blind.target, blind.target[recording.beside])
    assert (blind.target != UNKNOWN).all()
    assert purity(blind.target, recording.target) == 1.0
