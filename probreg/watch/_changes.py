"""Changes of biases: exact odds of a step or a ramp at every moment of late, and their sum."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from probreg.typing import FloatArray
from probreg.watch.state import Changes

SIZES = (
    0.03,
    0.1,
    0.3,
)  # standard deviations of a change, in those of the prior; ramps: in an hour
STEP_S, RAMP_S, RAMP_EVERY_S = 600.0, 1800.0, 60.0  # how long a change is in question
HOUR_S = 3600.0


class Slice(NamedTuple):
    """What the newest slice says of the knots, and what is believed after it if nothing changed.

    Attributes
    ----------
    J : ndarray, shape (C, C)
    surprise : ndarray, shape (C,)
        eta - J mean: what the belief leaves unexplained.
    covariance : ndarray, shape (C, C)
    """

    J: FloatArray
    surprise: FloatArray
    covariance: FloatArray


class Kind(NamedTuple):
    """A kind of change.

    Attributes
    ----------
    name : str
    growth : float
        Of a change of unit size from slice to slice: none for a step, whose size is there at
        once; of a ramp the length of a slice.
    scale : ndarray, shape (p,)
        What its sizes count in.
    lasts, every : int
        For how many slices a change is in question, and how many lie between those that are.
    """

    name: str
    growth: float
    scale: FloatArray
    lasts: int
    every: int


class Found(NamedTuple):
    """The most probable change.

    Attributes
    ----------
    begun : int
        Slice with which it began.
    term : int
    size, sd : float
    """

    begun: int
    term: int
    size: float
    sd: float


def no_changes(p: int, C: int) -> Changes:
    """Before the first slice."""
    return Changes(
        np.zeros(0, dtype=np.int64), np.zeros((0, p, C)), np.zeros((0, p)), np.zeros((0, p))
    )


def kinds_of(slice_s: float, prior_sd: FloatArray) -> tuple[Kind, Kind]:
    """Steps and ramps."""
    lasts = [max(1, round(s / slice_s)) for s in (STEP_S, RAMP_S, RAMP_EVERY_S)]
    step = Kind("step", 0.0, prior_sd, lasts[0], 1)
    return step, Kind("ramp", slice_s, prior_sd / HOUR_S, lasts[1], lasts[2])


def next_changes(changes: Changes, now: Slice, number: int, kind: Kind) -> Changes:
    """Scores with slice `number`."""
    p, C = changes.gap.shape[1:]
    own = np.arange(p)
    gap = np.roll(changes.gap, -p, axis=2)
    gap[:, :, -p:] = changes.gap[:, :, -p:]
    gap[:, own, C - p + own] += kind.growth
    begun, score, information = changes.begun, changes.score, changes.information
    if number % kind.every == 0:
        fresh, none = np.zeros((1, p, C)), np.zeros((1, p))
        fresh[0, own, C - p + own] = kind.growth or 1.0
        begun, gap = np.append(begun, number), np.concatenate([gap, fresh])
        score, information = np.vstack([score, none]), np.vstack([information, none])
    recent = begun > number - kind.lasts
    begun, gap, score, information = (
        begun[recent],
        gap[recent],
        score[recent],
        information[recent],
    )
    pull = gap @ now.J
    explained = pull @ now.covariance
    score = score + gap @ now.surprise
    information = information + np.einsum("hpc,hpc->hp", gap - explained, pull)
    return Changes(begun, gap - explained, score, information)


def log_odds(changes: Changes, scale: FloatArray) -> FloatArray:
    """Log odds (H, p, sizes) of each change against none, its size integrated out.

    `scale` (p,) is the size that the sizes in question count in.
    """
    variance = (scale[:, None] * np.array(SIZES)) ** 2
    grown = 1.0 + variance * changes.information[..., None]
    gain = 0.5 * changes.score[..., None] ** 2 * variance / grown
    return np.asarray(gain - 0.5 * np.log(grown))


def evidence(odds: tuple[FloatArray, ...]) -> float:
    """Log of the Shiryaev-Roberts sum, over moments, of the mean over kinds, biases and sizes."""
    sums = [logsumexp(one) - np.log(one[0].size) for one in odds if one.size]
    return float(logsumexp(sums) - np.log(len(odds))) if sums else -np.inf


def most_probable(changes: Changes, odds: FloatArray, scale: FloatArray) -> Found:
    """Moment, bias and size with the highest odds."""
    h, c, k = np.unravel_index(int(np.argmax(odds)), odds.shape)
    variance = float((scale[c] * SIZES[k]) ** 2)
    grown = 1.0 + variance * float(changes.information[h, c])
    size = variance * float(changes.score[h, c]) / grown
    return Found(int(changes.begun[h]), int(c), size, float(np.sqrt(variance / grown)))
