"""Targets followed on and on: filters that stop and go on, with knots of biases in a window."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks._equations import TrackEquations, TrackMotion
from probreg.motion.tracks._online import LiveTracks, Sums, follow
from probreg.typing import FloatArray, IntArray


def follow_tracks(
    equations: TrackEquations,
    motion: TrackMotion,
    columns: FloatArray,
    places: tuple[IntArray, IntArray],
    weights: FloatArray,
) -> tuple[Sums, LiveTracks]:
    """Information about biases at knots from tracks that began before these reports.

    Parameters
    ----------
    equations : TrackEquations
        Columns count biases at knots, knot by knot.
    motion : TrackMotion
        Starts are states at each target's first report here, with covariances.
    columns : ndarray, shape (K, size, C)
        What means of the starts lose for each unit of bias at each knot.
    places : tuple of (ndarray, ndarray), shape (n,)
        How many of the columns have a part in each report, and its group, from 0; neither goes
        down within a target.
    weights : ndarray, shape (n,)
        Precision of each report over the nominal one.

    Returns
    -------
    sums : Sums
        Of each group: what its reports say given those before them.
    live : LiveTracks
        After the last report of group 0 of each target; the start where there is none.
    """
    end, group = (np.asarray(part, dtype=np.int64) for part in places)
    C, groups = columns.shape[2], int(group.max(initial=0)) + 1
    if (equations.column >= end[equations.report][:, None]).any() or end.max(initial=0) > C:
        raise InvalidInputError(f"a column is beyond those of its report, or these beyond {C}.")
    sums = Sums(np.zeros((groups, C, C)), np.zeros((groups, C)), np.zeros(groups))
    begun = np.append(equations.time, np.nan)[equations.target_start[:-1]]
    start = motion.start_mean, motion.start_variance, columns
    mean, covariance, own = (np.array(part, order="C") for part in start)
    live = LiveTracks(mean, covariance, own, begun)
    precision = equations.precision(weights)
    follow(equations.shape, equations, motion, precision, (end, group), live, sums)
    below = np.tril(np.ones((C, C)), -1)
    return sums._replace(J=sums.J + np.swapaxes(below * sums.J, 1, 2)), live


def carried(live: LiveTracks, time: FloatArray, q: float, push: FloatArray) -> LiveTracks:
    """States carried on to later times (K,), under accelerations `push` (K, d) that are known.

    Earlier times leave them as they are.
    """
    K, size = live.mean.shape
    d, dt = push.shape[1], np.maximum(time - live.time, 0.0)
    F, Q = np.tile(np.eye(size), (K, 1, 1)), np.zeros((K, size, size))
    across = np.arange(d)
    F[:, across, d + across] = dt[:, None]
    Q[:, across, across] = (q * dt**3 / 3.0)[:, None]
    Q[:, across, d + across] = Q[:, d + across, across] = (q * dt**2 / 2.0)[:, None]
    Q[:, d + across, d + across] = (q * dt)[:, None]
    mean = np.einsum("kab,kb->ka", F, live.mean)
    mean[:, :d] += 0.5 * dt[:, None] ** 2 * push
    mean[:, d : 2 * d] += dt[:, None] * push
    covariance = F @ live.covariance @ np.swapaxes(F, 1, 2) + Q
    return LiveTracks(mean, covariance, F @ live.columns, live.time + dt)


def merged(live: LiveTracks, num_biases: int) -> LiveTracks:
    """Room for a new knot: the oldest one becomes one with the next.

    Exact for biases that are constant; a path forgets its biases within about a minute.
    """
    K, size, C = live.columns.shape
    by_knot = live.columns.reshape(K, size, C // num_biases, num_biases)
    columns = np.zeros_like(by_knot)
    columns[:, :, :-1] = by_knot[:, :, 1:]
    columns[:, :, 0] += by_knot[:, :, 0]
    return live._replace(columns=columns.reshape(K, size, C))
