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


def next_changes(
    changes: Changes, now: Slice, number: int, growth: float, keep: tuple[int, int]
) -> Changes:
    """Scores with one slice more.

    Parameters
    ----------
    changes : Changes
    now : Slice
    number : int
        Of the slice.
    growth : float
        Of a change of unit size from slice to slice: none for a step, whose size is there at
        once; of a ramp the length of a slice.
    keep : tuple of (int, int)
        For how many slices a change is in question, and how many lie between those that are.
    """
    lasts, every = keep
    p, C = changes.gap.shape[1:]
    own = np.arange(p)
    gap = np.roll(changes.gap, -p, axis=2)
    gap[:, :, -p:] = changes.gap[:, :, -p:]
    gap[:, own, C - p + own] += growth
    parts = [changes.begun, gap, changes.score, changes.information]
    if number % every == 0:
        fresh = np.zeros((1, p, C))
        fresh[0, own, C - p + own] = growth or 1.0
        new = np.array([number]), fresh, np.zeros((1, p)), np.zeros((1, p))
        parts = [np.concatenate(pair) for pair in zip(parts, new, strict=True)]
    recent = parts[0] > number - lasts
    begun, gap, score, information = (part[recent] for part in parts)
    pull = gap @ now.J
    explained = pull @ now.covariance
    score = score + gap @ now.surprise
    information = information + np.einsum("hpc,hpc->hp", gap, pull)
    information -= np.einsum("hpc,hpc->hp", explained, pull)
    return Changes(begun, gap - explained, score, information)


def log_odds(changes: Changes, scale: FloatArray) -> FloatArray:
    """Log odds (H, p, sizes) of each change against none, its size integrated out.

    `scale` (p,) is the size that the sizes in question count in.
    """
    variance = (scale[:, None] * np.array(SIZES)) ** 2
    grown = 1.0 + variance * changes.information[..., None]
    gain = 0.5 * changes.score[..., None] ** 2 * variance / grown
    return np.asarray(gain - 0.5 * np.log(grown))


def evidence(odds: FloatArray) -> float:
    """Log of the Shiryaev-Roberts sum, over moments, of the mean over biases and sizes."""
    if not odds.size:
        return -np.inf
    return float(logsumexp(odds) - np.log(odds[0].size))


def most_probable(changes: Changes, odds: FloatArray, scale: FloatArray) -> Found:
    """Moment, bias and size with the highest odds."""
    h, c, k = np.unravel_index(int(np.argmax(odds)), odds.shape)
    variance = float((scale[c] * SIZES[k]) ** 2)
    grown = 1.0 + variance * float(changes.information[h, c])
    size = variance * float(changes.score[h, c]) / grown
    return Found(int(changes.begun[h]), int(c), size, float(np.sqrt(variance / grown)))
