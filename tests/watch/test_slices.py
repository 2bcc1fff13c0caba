"""Slices as scans: together they say what the watch knows, and follow a bias that moves."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.scenarios.drifting import DriftingScene, Step, simulate
from probreg.scenarios.traffic import TrafficScene
from probreg.watch import WatchSettings, begin
from probreg.watch.slices import sliced

SCENE = TrafficScene(reports=7_000, wrong_share=0.2, outlier_share=0.05)


@cache
def watched(size: float, settings: WatchSettings, walk_deg: float):
    rng = np.random.default_rng(3)
    scene = DriftingScene(SCENE, {"radar1.azimuth": Step(200.0, np.deg2rad(size))})
    recording, setup, truth = simulate(scene, rng)
    state = begin(recording.during(-np.inf, 120.0), setup, settings, rng)
    walk = np.where([u == "rad" for u in state.units], np.deg2rad(walk_deg), 0.1) / np.sqrt(60.0)
    return state, recording, truth, sliced(state, recording, walk)


def test_scans_of_constant_biases_add_up_to_what_the_watch_believes():
    # no walk but the floor: the filter over the scans and the watch's own are one and the same
    settings = WatchSettings(drift=False, floor=1e-6)
    seen = watched(0.0, settings, 1e-9)[3]
    last = seen.model.filtered
    sd = np.sqrt(np.diag(last.covariance[-1]))
    # the watch knows the open reports too: closed ones alone are a little wider
    now = seen.results[-1]
    assert (np.abs(last.mean[-1] - now.mean) < 0.5 * sd).all()
    assert (sd > now.sd).all()
    assert (sd < 1.3 * now.sd).all()
    assert not np.any(seen.model.present[-1] < 1.0)


def test_the_exact_filter_over_the_scans_follows_a_step():
    _, _, truth, seen = watched(0.3, WatchSettings(), 0.05)
    model, own = seen.model, seen.model.names.index("radar1.azimuth")
    late = model.time > 250.0
    filtered, smoothed = model.filtered, model.smooth()
    for found in (filtered, smoothed):
        away = found.mean[late, own] - truth.bias("radar1.azimuth", model.time[late])
        z = away / np.sqrt(found.covariance[late, own, own])
        assert np.abs(np.rad2deg(away)).max() < 0.1  # a third of the step
        assert np.sqrt(np.mean(z**2)) < 2.5
    # a constant bias could not
    assert np.rad2deg(np.abs(np.diff(filtered.mean[:, own])).max()) > 0.03


def test_every_slice_is_a_scan_at_its_middle():
    state, recording, _, seen = watched(0.3, WatchSettings(), 0.05)
    ends = np.array([result.time for result in seen.results])
    np.testing.assert_allclose(np.diff(ends), 10.0)
    assert ends[-1] >= recording.time[-1] > ends[-2]
    # a slice closes a lag after it was new
    np.testing.assert_allclose(seen.model.time, ends - 55.0)
    assert sum(result.counts.used for result in seen.results) == (recording.time > state.time).sum()


def test_stamps_on_the_edges_of_slices_come_once():
    state, recording, _, _ = watched(0.3, WatchSettings(), 0.05)
    edges = state.origin + (state.slices + np.arange(4)) * state.settings.slice_s
    # as neighbours in floating point: a stamp may be an edge, or just beside it
    near = np.concatenate([edges[:-1], np.nextafter(edges[1:], 0.0), edges[1:],
                           np.nextafter(edges[1:-1], np.inf)])  # fmt: skip
    rows = np.searchsorted(recording.time, state.time) + np.arange(len(near))
    moved = replace(recording, **{
        name: getattr(recording, name)[rows] for name in ("sensor", "values", "target")
    }, time=np.sort(near))  # fmt: skip
    seen = sliced(state, moved, np.ones(6))
    used = [result.counts.used + result.counts.unplaced for result in seen.results]
    assert len(used) == 3
    # one stamp is that of the state itself: it is of the first minutes
    assert sum(used) == len(near) - 1


def test_a_recording_that_has_ended_is_refused():
    _, recording, _, seen = watched(0.3, WatchSettings(), 0.05)
    with pytest.raises(InvalidInputError, match="two slices"):
        sliced(seen.state, recording, np.ones(6))
