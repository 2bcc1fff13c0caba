"""Tracks of identities that return, against brute force."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.association import segments
from probreg.errors import InvalidInputError


def by_hand(target, time, gap_s):
    """Each report joins the track of the latest one before it of its identity, if near."""
    track, latest, owners = np.full(len(time), -1), {}, []
    for i in sorted(range(len(time)), key=lambda i: (target[i], time[i], i)):
        k = target[i]
        if k < 0:
            continue
        if k not in latest or time[i] - time[latest[k]] > gap_s:
            owners.append(k)
        track[i], latest[k] = len(owners) - 1, i
    return track, np.array(owners)


@pytest.mark.parametrize("seed", range(5))
def test_identities_are_split_at_long_gaps(seed):
    rng = np.random.default_rng(seed)
    target = rng.integers(-1, 12, 400)
    time = rng.uniform(-5_000.0, 5_000.0, 400)
    track, owners = segments(target, time, gap_s=250.0)
    expected = by_hand(target, time, 250.0)
    np.testing.assert_array_equal(track, expected[0])
    np.testing.assert_array_equal(owners, expected[1])
    assert len(owners) > 30  # of 12 identities
    np.testing.assert_array_equal(owners[track[track >= 0]], target[track >= 0])


def test_a_gap_of_just_the_limit_does_not_split():
    time = np.array([0.0, 300.0, 600.1])
    track, owners = segments(np.zeros(3, dtype=int), time)
    np.testing.assert_array_equal(track, [0, 0, 1])
    np.testing.assert_array_equal(owners, [0, 0])


def test_what_came_along_is_in_the_same_track():
    target = np.array([3, 3, -1, 3, 3])
    beside = np.array([0, 0, 2, 3, 3])
    # stamped by another clock: by itself it would be a track of its own
    time = np.array([0.0, 400.0, 10.0, 1_000.0, 1_001.0])
    track, owners = segments(target, time, beside)
    np.testing.assert_array_equal(track, [0, 0, -1, 1, 1])
    np.testing.assert_array_equal(owners, [3, 3])


def test_nothing_known_and_bad_input():
    track, owners = segments(np.full(3, -1), np.arange(3.0))
    np.testing.assert_array_equal(track, [-1, -1, -1])
    assert owners.size == 0
    assert segments(np.zeros(0, dtype=int), np.zeros(0))[0].size == 0
    with pytest.raises(InvalidInputError, match="gap_s"):
        segments(np.zeros(2, dtype=int), np.zeros(2), gap_s=0.0)
    with pytest.raises(InvalidInputError, match="time"):
        segments(np.zeros(2, dtype=int), np.array([0.0, np.nan]))
    with pytest.raises(InvalidInputError, match="target has shape"):
        segments(np.zeros(3, dtype=int), np.zeros(2))
    with pytest.raises(InvalidInputError, match="beside has shape"):
        segments(np.zeros(2, dtype=int), np.zeros(2), np.zeros(3, dtype=int))
