"""Thresholds for a stated rate of false alarms, by simulation of what slices say."""

from __future__ import annotations

import numba
import numpy as np

from probreg.typing import FloatArray, IntArray
from probreg.watch._changes import SIZES, Slice, next_changes, no_changes

HOURS = 300.0  # simulated
EASIER = (
    10.0  # times the rate wanted: there alarms are counted, and the tail falls as 1 / threshold
)
SETTLE_S = 3600.0


def steady(J: FloatArray, step: FloatArray, start: FloatArray, slices: int) -> FloatArray:
    """Covariance (C, C) of the knots after so many slices that all say J.

    `step` (p,) are variances of the steps, `start` (p,) those of the prior.
    """
    C, p = len(J), len(step)
    covariance = np.kron(np.ones((C // p, C // p)), np.diag(start))
    for _ in range(slices):
        shifted = np.empty_like(covariance)
        kept = np.r_[p:C, C - p : C]
        shifted[:] = covariance[np.ix_(kept, kept)]
        shifted[-p:, -p:] += np.diag(step)
        covariance = shifted - shifted @ J @ np.linalg.solve(np.eye(C) + shifted @ J, shifted)
        covariance = 0.5 * (covariance + covariance.T)
    return covariance


def change_threshold(
    J: FloatArray,
    covariance: FloatArray,
    scale: FloatArray,
    growth: float,
    keep: tuple[int, int],
    wanted: tuple[float, float],
    rng: np.random.Generator,
) -> float:
    """Log threshold of the evidence of changes that do not happen.

    `wanted` are the alarms in an hour and the slices of an hour.
    """
    rate, per_hour = wanted
    C, p = len(J), len(scale)
    lasts, every = keep
    spread = J - J @ covariance @ J
    values, vectors = np.linalg.eigh(0.5 * (spread + spread.T))
    seen = values > 1e-12 * values[-1]
    root = vectors[:, seen] * np.sqrt(values[seen])
    gaps, told = _ages(J, covariance, p, growth, lasts)
    lead = (gaps.reshape(-1, C) @ root).reshape(lasts, p, -1)
    variance = (scale[:, None] * np.array(SIZES)) ** 2
    n = int(HOURS * per_hour)
    sums = np.empty(n)
    score, begun = np.zeros((lasts // every + 1, p)), np.full(lasts // every + 1, -lasts)
    for low in range(0, n, 4096):
        noise = rng.standard_normal((min(4096, n - low), lead.shape[2]))
        _run(low, noise, lead, told, variance, every, (score, begun), sums[low : low + 4096])
    return _level(sums, EASIER * rate * HOURS, lasts) + float(np.log(EASIER))


def _ages(
    J: FloatArray, covariance: FloatArray, p: int, growth: float, lasts: int
) -> tuple[FloatArray, FloatArray]:
    """Gaps (ages, p, C) before each slice of a change, and information (ages, p) after it."""
    C = len(J)
    now = Slice(J, np.zeros(C), covariance)
    gaps, told = np.zeros((lasts, p, C)), np.zeros((lasts, p))
    own = np.arange(p)
    changes = no_changes(p, C)
    for age in range(lasts):
        before = changes.gap[0] if age else np.zeros((p, C))
        gaps[age] = np.roll(before, -p, axis=1)
        gaps[age][:, -p:] = before[:, -p:]
        gaps[age][own, C - p + own] += growth if age else growth or 1.0
        changes = next_changes(changes, now, age, growth, (lasts, lasts))
        told[age] = changes.information[0]
    return gaps, told


def _level(sums: FloatArray, count: float, apart: int) -> float:
    """The level that is crossed so often, crossings within `apart` slices counting once."""
    low, high = float(np.quantile(sums, 0.5)), float(sums.max())
    for _ in range(40):
        middle = 0.5 * (low + high)
        if _crossings(sums, middle, apart) > count:
            low = middle
        else:
            high = middle
    return high


@numba.njit(cache=True)
def _crossings(sums: FloatArray, level: float, apart: int) -> int:
    count, last = 0, -apart
    for t in range(len(sums)):
        if sums[t] > level and t - last >= apart:
            count += 1
            last = t
    return count


@numba.njit(cache=True)
def _run(
    first: int,
    noise: FloatArray,
    lead: FloatArray,
    told: FloatArray,
    variance: FloatArray,
    every: int,
    kept: tuple[FloatArray, IntArray],
    sums: FloatArray,
) -> None:
    """Write the log of the Shiryaev-Roberts sum of each slice; `kept` goes on to the next call."""
    score, begun = kept
    lasts, p, rank = lead.shape
    for t in range(len(noise)):
        now, total = first + t, 0.0
        if now % every == 0:
            place = (now // every) % len(begun)
            begun[place] = now
            score[place] = 0.0
        for h in range(len(begun)):
            age = now - begun[h]
            if age >= lasts:
                continue
            for c in range(p):
                gain = 0.0
                for r in range(rank):
                    gain += lead[age, c, r] * noise[t, r]
                score[h, c] += gain
                square = 0.5 * score[h, c] ** 2
                for k in range(variance.shape[1]):
                    grown = 1.0 + variance[c, k] * told[age, c]
                    total += np.exp(square * variance[c, k] / grown) / np.sqrt(grown)
        sums[t] = np.log(total / (p * variance.shape[1]))
