"""A watch against the batch posterior of the same reports; purity, lateness, forgetting, errors."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.motion.tracks import merged
from probreg.recordings import Setup
from probreg.watch import WatchSettings, _close, advance, from_arrays, to_arrays
from tests.watch.watched import batch, begun, cut, draw, in_slices, up_to, watched

CONSTANT = WatchSettings(drift=False, floor=1e-5)
REPORTS, LASTS_S = 6_000, 250.0


@pytest.fixture(scope="module")
def scene():
    recording, setup, _ = draw(3, reports=REPORTS)
    return recording, setup, begun(recording, setup, CONSTANT)


@pytest.fixture(scope="module")
def last(scene):
    recording, _, state = scene
    return watched(recording, state, recording.time[0] + LASTS_S)


def away(state, fit):
    """Largest difference of means, in posterior sds, and of sds, relative."""
    return (
        np.abs((state.mean - fit.theta) / fit.sd).max(),
        np.abs(state.sd / fit.sd - 1.0).max(),
    )


def test_it_begins_where_the_batch_fit_ends(scene):
    recording, setup, state = scene
    _, fit = batch(up_to(recording, 120.0), setup)
    mean, sd = away(state, fit)
    assert mean < 1e-3
    assert sd < 1e-4
    assert state.time >= recording.time[0] + 120.0 - state.settings.slice_s


def test_constant_biases_are_those_of_the_batch_posterior(scene, last):
    recording, setup, _ = scene
    _, fit = batch(up_to(recording, last[0].time - recording.time[0]), setup)
    mean, sd = away(last[0], fit)
    assert mean < 0.01
    assert sd < 0.002


def test_columns_that_are_dropped_are_missed(scene, last, monkeypatch):
    """The negative control: paths forget what they owe to older knots."""

    def dropped(live, p):
        found = merged(live, p)
        columns = found.columns.copy()
        columns[:, :, :p] -= live.columns[:, :, :p]
        return found._replace(columns=columns)

    monkeypatch.setattr(_close, "merged", dropped)
    recording, setup, state = scene
    found, _ = watched(recording, state, recording.time[0] + LASTS_S)
    _, fit = batch(up_to(recording, last[0].time - recording.time[0]), setup)
    assert away(found, fit)[0] > 0.02


def test_a_state_that_is_saved_goes_on_bit_for_bit(scene):
    recording, setup, state = scene
    first, second = list(in_slices(recording, state))[:2]
    there, result = advance(state, *first)
    file = io.BytesIO()
    np.savez(file, **to_arrays(there))
    file.seek(0)
    with np.load(file, allow_pickle=False) as loaded:
        again = from_arrays(dict(loaded), setup, CONSTANT)
    one, other = advance(there, *second), advance(again, *second)
    for left, right in ((one[0], other[0]), advance_twice(state, first)):
        arrays, same = to_arrays(left), to_arrays(right)
        assert arrays.keys() == same.keys()
        for name, value in arrays.items():
            np.testing.assert_array_equal(value, same[name], err_msg=name)
    assert one[1].to_json() == other[1].to_json()
    assert result.time == first[1]


def advance_twice(state, given):
    return advance(state, *given)[0], advance(state, *given)[0]


def test_numbers_of_identities_may_change_from_recording_to_recording(scene):
    recording, _, state = scene
    reports, until = next(in_slices(recording, state))
    turn = np.random.default_rng(0).permutation(len(reports.labels))
    labels = np.empty(len(turn), dtype=object)
    labels[turn] = reports.labels
    other = replace(reports, target=turn[reports.target], labels=tuple(labels))
    np.testing.assert_array_equal(
        advance(state, reports, until)[0].mean, advance(state, other, until)[0].mean
    )


def test_late_reports_are_used_and_later_ones_counted(scene, last):
    recording, _, state = scene
    end = recording.time[0] + LASTS_S
    late = (recording.sensor == 2) & (np.arange(len(recording)) % 2 == 0)
    parts = list(in_slices(recording, state, end))
    kept, counted, before = state, 0, -np.inf
    for _, until in parts:
        due = recording.time + np.where(late, 15.0, 0.0)
        rows = (due > before) & (due <= until) & (recording.time > state.time)
        before = until
        kept, result = advance(kept, cut(recording, rows), until)
        counted += result.counts.late
    assert counted == 0
    # all but those that are still to come
    assert np.abs((kept.mean - last[0].mean) / kept.sd).max() < 0.3
    assert np.abs(kept.sd / last[0].sd - 1.0).max() < 0.02
    old = cut(recording, (recording.time > kept.time - 55.0) & (recording.time < kept.time - 45.0))
    after, result = advance(kept, old, kept.time + 10.0)
    assert result.counts.late == len(old)
    assert result.counts.used == 0
    np.testing.assert_allclose(after.mean, kept.mean, atol=0.05 * kept.sd.max())


def test_without_reports_time_goes_by_and_tracks_are_forgotten(last):
    state = last[0]
    tracks = len(state.tracks.label)
    before = state
    for _ in range(20):
        state, result = advance(state, None, state.time + 10.0)
    assert tracks > 30
    assert len(state.tracks.label) == 0
    assert len(state.reports) == 0
    assert result.counts.used == 0
    np.testing.assert_allclose(state.mean, before.mean, atol=0.01 * before.sd.max())


def test_reports_without_identity_are_counted(scene):
    recording, _, state = scene
    reports, until = next(in_slices(recording, state))
    target = reports.target.copy()
    target[:7] = -1
    _, result = advance(state, replace(reports, target=target), until)
    assert result.counts.unplaced == 7
    assert result.counts.used == len(reports) - 7
    assert result.by_sensor.sum() == len(reports) - 7


def test_wrong_slices_sensors_and_states_are_refused(scene):
    recording, setup, state = scene
    reports, until = next(in_slices(recording, state))
    with pytest.raises(InvalidInputError, match="next slice ends at"):
        advance(state, reports, until + 1.0)
    with pytest.raises(InvalidInputError, match="later than the end"):
        advance(state, cut(recording, recording.time > until), until)
    with pytest.raises(InvalidInputError, match="sensors are"):
        advance(state, recording.only("radar1", "radar2"), until)
    arrays = to_arrays(state)
    with pytest.raises(InvalidInputError, match="another version, or of other sensors"):
        from_arrays(arrays, Setup(setup.sensors, {"radar1": ("range",)}), CONSTANT)
    with pytest.raises(InvalidInputError, match="another version, or of other sensors"):
        from_arrays(arrays, setup, WatchSettings())
    del arrays["filters.shift"]
    with pytest.raises(InvalidInputError, match=r"damaged: 'filters\.shift' is missing"):
        from_arrays(arrays, setup, CONSTANT)


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"lag_s": 55.0}, "whole number of slices"),
        ({"window": 6}, "7 or more knots"),
        ({"delay_s": 55.0}, "at most 50"),
        ({"slice_s": 0.0}, "slice_s"),
        ({"floor": 0.0}, "floor"),
    ],
)
def test_settings_that_cannot_be_are_refused(given, match):
    with pytest.raises(InvalidInputError, match=match):
        WatchSettings(**given)
