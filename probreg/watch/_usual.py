"""What is usual of the noise scores of each sensor, and sums of evidence that they have shifted.

The score of a slice is the log likelihood ratio of less, or of more noise. Laws and accelerations
are estimates, so that its mean is not that of the model: every sensor is judged against its own
mean and long-run variance, with Student's law while these are little known. The sums depend on
nothing else, and their threshold is that of the same recursion fed with normal numbers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import ndtri, stdtr

from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.watch.state import NoiseScores

SHIFTS = (2.0, 4.0)  # of scores, in standard deviations: smaller ones are an error of the mean
CLIP = 4.0  # of a slice's score: one slice alone raises no alarm, whatever is in it
LEARN = 18  # slices of which the usual is learned first
MEMORY_S = 900.0  # half-life of what is usual
RECENT = 0.7  # of the ratios by which a factor is named, from slice to slice
MOST_HUNG = 0.9  # correlation of neighbouring slices
SEQUENCES, SLICES, BLOCK = 500, 2000, 200  # simulated; the highest sum of a block counts
FEW = 10  # blocks beyond a threshold, below which rates are extrapolated


def no_scores(models: int, factors: int) -> NoiseScores:
    """Nothing is usual yet."""
    none = np.zeros((models, 2))
    sums = np.full((models, 2, len(SHIFTS)), -np.inf)
    once = np.zeros(models)
    return NoiseScores(once, once, none, none, none, none, sums, np.zeros((models, factors)))


def next_scores(
    scores: NoiseScores, ratio: FloatArray, counts: IntArray, compared: tuple[int, int], fade: float
) -> NoiseScores:
    """With one slice more.

    Parameters
    ----------
    scores : NoiseScores
    ratio : ndarray, shape (models, factors)
        Log likelihood ratios of the slice by factor on the noise.
    counts : ndarray of int, shape (models,)
        Reports that they are sums over; models without any stay as they are.
    compared : tuple of (int, int)
        Factors for less and for more noise.
    fade : float
        Of what was usual, from slice to slice.
    """
    there = (counts > 0)[:, None]
    n = np.maximum(counts, 1)[:, None].astype(float)
    root = np.sqrt(n)
    away = root * (ratio[:, compared] / n - scores.mean)
    slices, reports = fade * scores.slices + 1.0, fade * scores.reports[:, None] + n
    ready = there & (scores.slices >= LEARN)[:, None]
    spread = _spread(scores, n)
    z = _normal(away / spread, scores.slices[:, None] - 1.0)
    shifts = np.array(SHIFTS)
    gain = shifts * z[..., None] - 0.5 * shifts**2
    sums = np.logaddexp(0.0, scores.sums) + gain
    # what is not usual must not become so at once. A shift of less than three standard deviations
    # may, in minutes: if nothing were learned under suspicion, heights that hang together alarmed
    away = np.where(ready, np.clip(away, -CLIP * spread, CLIP * spread), away)
    mean = scores.mean + root * away / reports
    square = away**2 * (1.0 - n / reports)
    variance = scores.variance + (square - scores.variance) / slices[:, None]
    product = scores.product + (away * scores.last - scores.product) / slices[:, None]
    last = np.where(scores.slices[:, None] > 0.0, away, 0.0)  # the first one is away from nothing
    suspected = (strengths(scores) > 0.0).any(axis=1, keepdims=True)
    return NoiseScores(
        np.where(there[:, 0], slices, scores.slices),
        np.where(there, reports, scores.reports[:, None])[:, 0],
        np.where(there, mean, scores.mean),
        np.where(there, variance, scores.variance),
        np.where(there, product, scores.product),
        np.where(there, last, scores.last),
        np.where(ready[..., None], sums, scores.sums),
        np.where(suspected, RECENT, 0.0) * scores.recent + ratio,
    )


def _spread(scores: NoiseScores, n: FloatArray) -> FloatArray:
    """Standard deviation (models, 2) of a score about its mean, in the long run."""
    least = np.finfo(float).tiny
    variance = np.maximum(scores.variance, least)
    hung = np.clip(scores.product / variance, 0.0, MOST_HUNG)
    own = n / np.maximum(scores.reports[:, None], 1.0)
    return np.asarray(np.sqrt(variance * (1.0 + hung) / (1.0 - hung) * (1.0 + own)))


def _normal(t: FloatArray, freedom: FloatArray) -> FloatArray:
    """Normal numbers as improbable as those of Student's law, clipped."""
    return np.asarray(np.clip(ndtri(stdtr(np.maximum(freedom, 1.0), t)), -CLIP, CLIP))


def strengths(scores: NoiseScores) -> FloatArray:
    """Log evidence (models, 2) of less and of more noise, the mean over shifts."""
    return np.asarray(np.logaddexp.reduce(scores.sums, axis=2) - np.log(scores.sums.shape[2]))


def forgotten(scores: NoiseScores, models: BoolArray) -> NoiseScores:
    """Some models (models,) begin afresh."""
    none = no_scores(*scores.recent.shape)
    parts = {
        name: np.where(models.reshape(-1, *[1] * (part.ndim - 1)), getattr(none, name), part)
        for name, part in vars(scores).items()
    }
    return NoiseScores(**parts)


def unsuspected(scores: NoiseScores) -> NoiseScores:
    """With the sums, but not with what is usual, begun afresh."""
    return replace(scores, sums=np.full_like(scores.sums, -np.inf))


def fade_of(slice_s: float) -> float:
    """What is kept of the usual from slice to slice."""
    return float(0.5 ** (slice_s / MEMORY_S))


def noise_threshold(per_slice: float, fade: float, rng: np.random.Generator) -> float:
    """Log threshold that one sum passes so often in a slice, while its scores only scatter.

    The highest sums of blocks are exceedances of a Poisson process, but for those that hang
    together; rates below those that a simulation counts follow the slope of its tail.
    """
    scores, highest = no_scores(SEQUENCES, 2), []
    counts = np.ones(SEQUENCES, dtype=np.int64)
    best = np.full((SEQUENCES, 2), -np.inf)
    for number in range(LEARN + SLICES):
        scores = next_scores(scores, rng.standard_normal((SEQUENCES, 2)), counts, (0, 1), fade)
        best = np.maximum(best, strengths(scores))
        if number >= LEARN and (number - LEARN + 1) % BLOCK == 0:
            highest.append(best.ravel())
            best = np.full((SEQUENCES, 2), -np.inf)
    blocks = np.sort(np.concatenate(highest))[::-1]
    wanted = -np.expm1(-BLOCK * per_slice) * len(blocks)
    if wanted >= FEW:
        return float(blocks[min(int(wanted), len(blocks) - 1)])
    high, low = blocks[FEW], blocks[10 * FEW]
    return float(high + (high - low) / np.log(10.0) * np.log(FEW / wanted))
