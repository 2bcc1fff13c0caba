"""How often sensors report a target, against the scans that made the recording."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import Radar2D
from probreg.association import comparison_window, usual_intervals
from probreg.recordings import Recording, Setup, places
from probreg.scenarios.traffic import TrafficScene, simulate
from tests.problems.test_recording import SEEN, with_bearings
from tests.registration.conftest import fly

SCANS = (4.0, 7.0, 12.0)


def seen(wrong_share=0.0):
    scene = TrafficScene(4_000, scan_s=SCANS, wrong_share=wrong_share)
    recording, setup, _ = simulate(scene, np.random.default_rng(2))
    return recording, setup, places(recording, setup, recording.values)


@pytest.mark.parametrize("wrong_share", [0.0, 0.2])
def test_identities_tell_the_scans(wrong_share):
    recording, setup, where = seen(wrong_share)
    found = usual_intervals(recording, setup, where)
    # an aircraft keeps its place in the turn to a fraction of it
    np.testing.assert_allclose(found, SCANS, rtol=0.06)
    assert comparison_window(found) == pytest.approx(2.0 * max(found))


def test_places_tell_them_where_there_are_no_identities():
    recording, setup, where = seen()
    blind = dataclasses.replace(recording, target=np.full(len(recording), -1))
    np.testing.assert_allclose(usual_intervals(blind, setup, where), SCANS, rtol=0.06)


def test_gaps_of_hours_do_not_count():
    time = np.array([0.0, 4.0, 4_000.0, 8_000.0, 12_000.0, 12_004.0])
    assert np.median(np.diff(time)) > 3_000.0
    radar = Radar2D((0.0, 0.0), 20.0, 1e-3, "a")
    values = np.tile([10e3, 0.1], (6, 1))
    none = np.zeros(6, dtype=int)
    recording = Recording((radar,), none, time, values, none)
    found = usual_intervals(recording, Setup((radar,), {}), radar.to_cartesian(values))
    np.testing.assert_array_equal(found, [4.0])


def test_bearings_without_identity_tell_nothing():
    made = fly(with_bearings(), SEEN)
    where = places(made.recording, made.setup, made.recording.values)
    named = usual_intervals(made.recording, made.setup, where)
    np.testing.assert_allclose(named, [4.0, 5.0, 6.0][: len(named)], rtol=1e-9)
    silent = dataclasses.replace(made.recording, target=np.full(len(made.recording), -1))
    found = usual_intervals(silent, made.setup, where)
    assert np.isnan(found[1])
    assert np.isfinite(np.delete(found, 1)).all()


def test_the_window_has_a_least():
    assert comparison_window(np.array([0.1, np.nan])) == 1.0
    assert comparison_window(np.array([np.nan])) == 1.0
    assert comparison_window(np.array([0.1, 3.0, np.nan])) == 6.0
