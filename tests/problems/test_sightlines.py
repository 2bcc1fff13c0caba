"""Lines of sight: their crossings against a known emitter, their parallax against its noise."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.problems import _sightlines as lines

EMITTER = np.array([4e3, 9e3])


def track(n=40, heading=0.0, step=200.0):
    return step * np.arange(float(n))[:, None] * [np.cos(heading), np.sin(heading)]


def azimuths(own, place, sigma=0.0, seed=1):
    away = place - own
    noise = sigma * np.random.default_rng(seed).standard_normal(len(own))
    return np.arctan2(away[:, 1], away[:, 0]) + noise


def test_clean_lines_meet_at_the_emitter_however_they_are_paired():
    own = track()
    found = lines.meeting_points(azimuths(own, EMITTER), own)
    assert len(found) == 1 + 20  # all lines, and one pair for each of the first half
    np.testing.assert_allclose(found, np.broadcast_to(EMITTER, found.shape), atol=1e-6)


def test_parallel_pairs_give_no_crossing():
    own = track(n=2)
    found = lines.meeting_points(np.full(2, 0.5 * np.pi), own)
    assert len(found) == 1


def test_points_ahead_lie_on_the_median_line_and_pass_the_emitter():
    own = track(n=3, step=0.0)
    azimuth = azimuths(own, EMITTER)
    azimuth[2] += 1.0  # the median bears one outlier
    found = lines.points_ahead(azimuth, own)
    across = np.array([-EMITTER[1], EMITTER[0]]) / np.linalg.norm(EMITTER)
    assert np.abs(found @ across).max() < 1e-6 * np.abs(found).max()
    distance = np.linalg.norm(found, axis=1)
    assert (found @ EMITTER > 0.0).all()
    assert distance[0] < np.linalg.norm(EMITTER) < distance[-1]


@pytest.mark.parametrize(("place", "sigma", "told"), [
    (EMITTER, 1e-3, True),
    (EMITTER, 1e-2, True),
    (np.array([4e3, 9e7]), 1e-3, False),  # parallax far below the noise
    (np.array([5e6, 0.0]), 1e-3, False),  # dead ahead
])  # fmt: skip
def test_a_distance_is_told_by_parallax_above_the_noise(place, sigma, told):
    own = track()
    direction = lines.parallel_direction(azimuths(own, place, sigma), own, np.full(len(own), sigma))
    assert (direction is None) == told
    if not told:
        expected = place / np.linalg.norm(place)
        assert abs(direction @ expected) == pytest.approx(1.0, abs=1e-5)


def test_an_outlier_that_cancels_the_slope_does_not_hide_a_parallax():
    own = track()
    azimuth = azimuths(own, np.array([4e3, 60e3]), 1e-3)
    along = own[:, 0] - own[:, 0].mean()
    azimuth[-1] -= along @ azimuth / along[-1]  # the least-squares slope is zero now
    assert lines.parallel_direction(azimuth, own, np.full(40, 1e-3)) is None
