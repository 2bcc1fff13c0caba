"""The engine of drifting biases against dense algebra, and against that of constant ones."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.motion.tracks import eliminate_drifting, eliminate_paths
from tests.motion.dense_tracks import dense_posterior, random_tracks

STATIC, DRIFTING = 2, 2


def with_knots(tracks, knots):
    """The last two of four biases at knots, linear between them."""
    equations = tracks.equations
    time = equations.time[equations.report]
    left = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, len(knots) - 2)
    share = np.clip((time - knots[left]) / np.diff(knots)[left], 0.0, 1.0)
    column, response = [], []
    for c, s in zip(equations.column.T, equations.response.T, strict=True):
        drifts = c >= STATIC
        for knot, part in ((left, 1.0 - share), (left + 1, share)):
            place = STATIC + knot * DRIFTING + (c - STATIC)
            column.append(np.where(drifts, place, c))
            response.append(s * np.where(drifts, part, 0.5))
    equations = equations._replace(
        column=np.ascontiguousarray(np.transpose(column)),
        response=np.ascontiguousarray(np.transpose(response)),
    )
    return tracks._replace(equations=equations, num_biases=STATIC + DRIFTING * len(knots))


def found(tracks, knots):
    return eliminate_drifting(
        tracks.equations, tracks.motion, (STATIC, DRIFTING), knots, tracks.weights
    )


@pytest.mark.parametrize("push", [False, True])
@pytest.mark.parametrize(("d", "c"), [(2, 0), (3, 2)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_information_is_that_of_dense_algebra_where_all_knots_live(seed, d, c, push):
    knots = np.array([95.0, 110.0, 118.0, 140.0, 154.0])
    tracks = with_knots(random_tracks(seed, d, c, start_sd=(1e3, 30.0, 40.0), push=push), knots)
    got = found(tracks, knots)
    dense = [dense_posterior(tracks, k) for k in range(len(tracks.motion.q))]
    J, eta = sum(one.J for one in dense), np.array([one.eta for one in dense])
    assert np.abs(got.precision - J).max() < 1e-10 * np.abs(J).max()
    assert np.abs(got.shift_by_target - eta).max() < 1e-10 * np.abs(eta).max()
    ll = np.array([one.ll for one in dense])
    np.testing.assert_allclose(got.log_likelihood_by_target, ll, rtol=1e-11)
    assert (got.telling == (np.abs(eta) > 0.0).any(axis=1)).all()


def long_tracks(seed):
    """Reports over many minutes, so that knots leave the window."""
    tracks = random_tracks(seed, targets=6)
    time = 100.0 + 20.0 * (tracks.equations.time - 100.0)
    return tracks._replace(equations=tracks.equations._replace(time=time))


@pytest.mark.parametrize("spacing", [20.0, 50.0, 300.0])
@pytest.mark.parametrize("seed", [4, 5, 6])
def test_knots_that_are_tied_say_what_a_constant_says(seed, spacing):
    """Merging, not dropping: whatever the window, sums over knots are those of constants."""
    tracks = long_tracks(seed)
    knots = np.arange(80.0, 1400.0, spacing)
    got = found(with_knots(tracks, knots), knots)
    constant = eliminate_paths(*tracks)
    tie = np.zeros((STATIC + DRIFTING * len(knots), STATIC + DRIFTING))
    tie[:STATIC, :STATIC] = np.eye(STATIC)
    tie[STATIC:, STATIC:] = np.tile(np.eye(DRIFTING), (len(knots), 1))
    J, eta = tie.T @ got.precision @ tie, got.shift_by_target @ tie
    assert np.abs(J - constant.precision).max() < 1e-10 * np.abs(J).max()
    assert np.abs(eta - constant.shift_by_target).max() < 1e-10 * np.abs(eta).max()
    assert got.log_likelihood == pytest.approx(constant.log_likelihood, rel=1e-12)


def test_what_leaves_the_window_is_the_difference_to_dense_algebra():
    """The control: a window of a minute is not exact where acceleration is next to none."""
    tracks = long_tracks(4)
    knots = np.arange(80.0, 1400.0, 20.0)
    still = with_knots(tracks._replace(motion=tracks.motion._replace(q=np.full(6, 1e-9))), knots)
    dense = sum(dense_posterior(still, k).J for k in range(6))
    assert np.abs(found(still, knots).precision - dense).max() > 1e-6 * np.abs(dense).max()


def test_too_many_coefficients_and_strange_columns_are_refused():
    tracks = long_tracks(4)
    with pytest.raises(InvalidInputError, match=r"4002 coefficients, of at most 2000"):
        found(tracks, np.arange(2000.0))
    with pytest.raises(InvalidInputError, match=r"a column is \d+; there are 6"):
        found(with_knots(tracks, np.arange(80.0, 1400.0, 100.0)), np.array([0.0, 900.0]))
