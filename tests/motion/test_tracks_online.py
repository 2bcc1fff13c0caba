"""Filters that stop and go on, against those that never stopped."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.motion.tracks import (
    LiveTracks,
    TrackMotion,
    carried,
    eliminate_paths,
    follow_tracks,
    merged,
    smooth_tracks,
)
from tests.motion.dense_tracks import random_tracks

P = 4


def full(motion):
    """The same starts with covariances instead of variances."""
    size = motion.start_mean.shape[1]
    return motion._replace(start_variance=motion.start_variance[:, :, None] * np.eye(size))


def whole(tracks, groups=None):
    equations, motion, _, weights = tracks
    n, size = len(equations.time), motion.start_mean.shape[1]
    group = np.zeros(n, dtype=int) if groups is None else groups
    columns = np.zeros((len(motion.q), size, P))
    return follow_tracks(equations, full(motion), columns, (np.full(n, P), group), weights)


@pytest.mark.parametrize(("d", "c"), [(2, 0), (3, 0), (2, 1)])
@pytest.mark.parametrize("push", [False, True])
def test_sums_are_those_of_paths_eliminated_at_once(d, c, push):
    tracks = random_tracks(1, d, c, p=P, push=push)
    wanted = eliminate_paths(*tracks)
    half = (np.arange(len(tracks.equations.time)) % 5 > 2).astype(int)
    half = np.maximum.accumulate(half)  # goes up within every target
    for groups in (None, half):
        sums, _ = whole(tracks, groups)
        np.testing.assert_allclose(sums.J.sum(axis=0), wanted.precision, rtol=1e-9)
        np.testing.assert_allclose(sums.eta.sum(axis=0), wanted.shift, rtol=1e-9)
        assert sums.log_likelihood.sum() == pytest.approx(wanted.log_likelihood)


def test_going_on_from_where_it_stopped_is_not_stopping():
    tracks = random_tracks(2, p=P, targets=1, push=True)
    equations, motion, _, weights = tracks
    n = len(equations.time)
    cut = n // 2
    groups = (np.arange(n) >= cut).astype(int)
    sums, live = whole(tracks, groups)
    first = equations.report_start[cut]
    rest = equations._replace(
        target_start=np.array([0, n - cut]),
        report_start=equations.report_start[cut:] - first,
        time=equations.time[cut:],
        push=equations.push[cut:],
        **{name: getattr(equations, name)[first:]
           for name in ("y", "h", "variance", "column", "response")},
    )  # fmt: skip
    on = carried(live, rest.time[:1], float(motion.q[0]), rest.push[:1])
    start = TrackMotion(motion.q, on.mean, on.covariance)
    places = np.full(n - cut, P), np.zeros(n - cut, dtype=int)
    found, _ = follow_tracks(rest, start, on.columns, places, weights[cut:])
    np.testing.assert_allclose(found.J[0], sums.J[1], rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(found.eta[0], sums.eta[1], rtol=1e-8, atol=1e-12)
    smoothed = smooth_tracks(rest, start, weights[cut:], spread=True)
    wanted = smooth_tracks(equations, motion, weights, spread=True)
    np.testing.assert_allclose(smoothed.mean, wanted.mean[cut:], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(smoothed.spread, wanted.spread[first:], rtol=1e-6)


def test_means_lose_their_columns_times_the_biases():
    tracks = random_tracks(3, p=P)
    delta = np.array([3.0, -2.0, 0.5, 1.0])
    _, live = whole(tracks)
    shifted = tracks.equations._replace(y=tracks.equations.minus_biases(delta))
    _, moved = whole(tracks._replace(equations=shifted))
    np.testing.assert_allclose(moved.mean, live.mean - live.columns @ delta, rtol=1e-8)


def test_merging_keeps_what_is_lost_to_constant_biases():
    rng = np.random.default_rng(0)
    live = LiveTracks(
        rng.normal(size=(3, 4)), np.zeros((3, 4, 4)), rng.normal(size=(3, 4, 6)), np.zeros(3)
    )
    found = merged(live, 2).columns.reshape(3, 4, 3, 2)
    before = live.columns.reshape(3, 4, 3, 2)
    np.testing.assert_allclose(found.sum(axis=2), before.sum(axis=2))
    np.testing.assert_array_equal(found[:, :, -1], 0.0)
    np.testing.assert_array_equal(found[:, :, 0], before[:, :, 0] + before[:, :, 1])


def test_earlier_times_carry_nothing_back():
    live = LiveTracks(np.ones((1, 4)), np.eye(4)[None], np.ones((1, 4, 2)), np.array([10.0]))
    there = carried(live, np.array([9.0]), 1.0, np.zeros((1, 2)))
    np.testing.assert_array_equal(there.mean, live.mean)
    assert there.time[0] == 10.0


def test_columns_beyond_those_of_a_report_are_refused():
    tracks = random_tracks(4, p=P)
    n = len(tracks.equations.time)
    columns = np.zeros((len(tracks.motion.q), 4, P))
    places = np.full(n, P - 1), np.zeros(n, dtype=int)
    with pytest.raises(InvalidInputError, match="a column is beyond"):
        follow_tracks(tracks.equations, full(tracks.motion), columns, places, tracks.weights)
