"""Tracks of targets: the reports of one identity without a long gap between them."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import UNKNOWN
from probreg.typing import FloatArray, IntArray
from probreg.validation import finite_array, positive_number

GAP_S = 300.0  # long enough for a valley or a turn out of coverage, short for a shared code


def segments(
    target: IntArray, time: FloatArray, beside: IntArray | None = None, gap_s: float = GAP_S
) -> tuple[IntArray, IntArray]:
    """Number the tracks: reports of one identity are split where they are long apart.

    An identity that returns after a long gap, such as a Mode 3/A code, may be of another target,
    and if it is not, its path before says nothing of it.

    Parameters
    ----------
    target : ndarray of int, shape (n,)
        Identities, -1 where there is none.
    time : ndarray, shape (n,)
        Seconds, in any order.
    beside : ndarray of int, shape (n,), optional
        Number of the report that each came with, as in a `Recording`: it is in that one's track.
    gap_s : float
        Longest time between consecutive reports of a track.

    Returns
    -------
    track : ndarray of int, shape (n,)
        From 0, in order of identity and time; -1 where the identity is.
    target_of_track : ndarray of int, shape (K,)
        The identity of each track.

    Raises
    ------
    InvalidInputError
        Lengths that do not fit, times that are not finite, a gap that is not positive.
    """
    time = finite_array("time", time, (None,))
    gap_s = positive_number("gap_s", gap_s)
    for name, array in (("target", target), ("beside", beside)):
        if array is not None and np.shape(array) != time.shape:
            raise InvalidInputError(f"{name} has shape {np.shape(array)}, time {time.shape}.")
    known = np.asarray(target) != UNKNOWN
    if beside is not None:
        known &= np.asarray(beside) == np.arange(len(time))
    rows = np.flatnonzero(known)
    rows = rows[np.lexsort((time[rows], target[rows]))]
    own = target[rows]
    first = (np.diff(own, prepend=UNKNOWN) != 0) | (np.diff(time[rows], prepend=0.0) > gap_s)
    track = np.full(len(time), UNKNOWN)
    track[rows] = np.cumsum(first) - 1
    if beside is not None:
        track = track[beside]
    return track, own[first]
