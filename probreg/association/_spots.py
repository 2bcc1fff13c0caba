"""Where targets are, compared horizontally; heights speak only where both sides know theirs.

The height of a report without one is a guess, and barometric heights are hundreds of metres off:
neither may decide who is near whom, but thousands of metres apart are two targets.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.typing import BoolArray, FloatArray, IntArray

CLIMB_M_S = 50.0  # few aircraft climb or dive faster
_ALONE = 0.1  # of the window: for how long a target of one report is where it was


class Spots(NamedTuple):
    """Places of targets, and what is known of their heights.

    Attributes
    ----------
    where : ndarray, shape (n, d)
        Metres; NaN nowhere. The third coordinate may be a guess.
    height : ndarray, shape (n,)
        The third coordinate where it is none; else NaN.
    room : ndarray, shape (n,)
        Half of how far, in metres, heights of one target may differ.
    """

    where: FloatArray
    height: FloatArray
    room: FloatArray

    def take(self, rows: IntArray) -> Spots:
        """Some of them."""
        return Spots(*(part[rows] for part in self))

    def away(self, others: Spots) -> FloatArray:
        """Horizontal distances (n,)."""
        gap = self.where[:, :2] - others.where[:, :2]
        return np.sqrt(np.einsum("nd,nd->n", gap, gap))

    def elsewhere(self, others: Spots) -> BoolArray:
        """Whether heights, where both are known, are too different for one target, (n,)."""
        found: BoolArray = np.abs(self.height - others.height) > self.room + others.room
        return found


def between(
    time: FloatArray, spots: Spots, at: FloatArray, window: float
) -> tuple[Spots, BoolArray]:
    """Where a target is at other times (k,), and whether its reports are near enough to say.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Of its reports, not decreasing, seconds.
    spots : Spots
        Of its reports.
    at : ndarray, shape (k,)
    window : float
        Longest time between reports that are compared.
    """
    if len(time) == 1:
        lasting = np.abs(at - time[0]) <= _ALONE * window
        return spots.take(np.zeros(len(at), dtype=np.int64)), lasting
    after = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    gap = time[after] - time[after - 1]
    share = (at - time[after - 1]) / np.where(gap > 0.0, gap, 1.0)
    inside = (share >= -0.1) & (share <= 1.1) & (gap <= 3.0 * window)
    one, two = spots.take(after - 1), spots.take(after)
    where = one.where + share[:, None] * (two.where - one.where)
    height = one.height + share * (two.height - one.height)
    return Spots(where, height, np.maximum(one.room, two.room)), inside
