"""Reports that no path could join to their neighbours in time start without a say."""

from __future__ import annotations

import numba
import numpy as np

from probreg.posterior.tracks.model import WIDEST_M, TrackModel
from probreg.problems.recording.track_reports import TrackLinearisation
from probreg.typing import BoolArray, FloatArray, IntArray

NEIGHBOURS = 6  # of the same target, before and after
FASTEST = 3.0  # standard deviations of the velocity at the start


def in_company(model: TrackModel, tangent: TrackLinearisation) -> BoolArray:
    """Which reports (n,) lie within reach of as many of their neighbours as most, or near it.

    In the order of the tangent. A share of half that of the best of its target will do: where
    names are wrong a target's own reports are in reach of each other, the others of few.
    """
    assert model.guess is not None
    equations = tangent.equations
    position = model.guess.position[tangent.rows]
    share = _reached(
        equations.target_start, equations.time, position, FASTEST * model.start_sd[2], WIDEST_M
    )
    best = np.zeros(len(equations.target_start) - 1)
    np.maximum.at(best, equations.target, share)
    return np.asarray(share >= 0.5 * best[equations.target])


@numba.njit(cache=True)
def _reached(
    target_start: IntArray, time: FloatArray, position: FloatArray, speed: float, slack: float
) -> FloatArray:
    """Share (n,) of the neighbours in time that are within reach; one if there are none."""
    share = np.ones(len(time))
    for k in range(len(target_start) - 1):
        low, high = target_start[k], target_start[k + 1]
        for i in range(low, high):
            near, all_of_them = 0, 0
            for j in range(max(low, i - NEIGHBOURS), min(high, i + NEIGHBOURS + 1)):
                if j == i:
                    continue
                away = 0.0
                for a in range(position.shape[1]):
                    away += (position[i, a] - position[j, a]) ** 2
                all_of_them += 1
                near += away < (slack + speed * abs(time[i] - time[j])) ** 2
            if all_of_them > 0:
                share[i] = near / all_of_them
    return share
