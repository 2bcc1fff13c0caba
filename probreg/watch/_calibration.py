"""Thresholds for a stated rate of false alarms, by simulation of what slices say."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from probreg.typing import FloatArray, IntArray
from probreg.watch._changes import SIZES, Kind, Slice, next_changes, no_changes

HOURS = 200.0  # simulated
COUNTED_PER_HOUR = 0.5  # alarms at least: rarer ones by a tail that falls as 1 / threshold
SETTLE_S, BLOCK = 3600.0, 4096


class Known(NamedTuple):
    """Of steps and ramps, what does not depend on noise.

    Attributes
    ----------
    lead : tuple of ndarray, shape (ages, p, rank)
        What a unit of each noise adds to the score of a change of that age.
    told : tuple of ndarray, shape (ages, p)
        Information about a change of that age.
    variance : tuple of ndarray, shape (p, sizes)
    every : ndarray of int, shape (2,)
    """

    lead: tuple[FloatArray, ...]
    told: tuple[FloatArray, ...]
    variance: tuple[FloatArray, ...]
    every: IntArray


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
    kinds: tuple[Kind, Kind],
    wanted: tuple[float, float],
    rng: np.random.Generator,
) -> float:
    """Log threshold of the evidence of changes that do not happen.

    `wanted` are the alarms in an hour and the slices of an hour.
    """
    (rate, per_hour), p = wanted, len(kinds[0].scale)
    spread = J - J @ covariance @ J
    values, vectors = np.linalg.eigh(0.5 * (spread + spread.T))
    seen = values > 1e-12 * values[-1]
    root = vectors[:, seen] * np.sqrt(values[seen])
    ages = [_ages(J, covariance, kind) for kind in kinds]
    leads = tuple(np.ascontiguousarray(gaps @ root) for gaps, _ in ages)
    variances = tuple((kind.scale[:, None] * np.array(SIZES)) ** 2 for kind in kinds)
    every = np.array([kind.every for kind in kinds])
    known = Known(leads, tuple(told for _, told in ages), variances, every)
    easier = max(COUNTED_PER_HOUR / rate, 1.0)
    n, count = int(HOURS * per_hour), easier * rate * HOURS
    seed = int(rng.integers(2**32))
    sums = np.empty(n)
    _simulated(known, (p, seed, np.inf), sums)
    level = _level(sums, count, kinds[0].lasts)
    # an alarm begins all sums again, which none has done so far
    alarms = max(_simulated(known, (p, seed, level), sums), 1)
    return level + float(np.log(alarms / count) + np.log(easier))


def _simulated(known: Known, how: tuple[int, int, float], sums: FloatArray) -> int:
    """Write the log evidence of slices, drawn from a seed, with alarms at a level; their number."""
    p, seed, level = how
    rng, alarms = np.random.default_rng(seed), 0
    lasts = [len(told) for told in known.told]
    rows = [last // every + 1 for last, every in zip(lasts, known.every.tolist(), strict=True)]
    score = tuple(np.zeros((k, p)) for k in rows)
    begun = tuple(np.full(k, -last) for k, last in zip(rows, lasts, strict=True))
    for low in range(0, len(sums), BLOCK):
        part = sums[low : low + BLOCK]
        noise = rng.standard_normal((len(part), known.lead[0].shape[2]))
        alarms += _run(low, noise, known, (score, begun), level, part)
    return alarms


def _ages(J: FloatArray, covariance: FloatArray, kind: Kind) -> tuple[FloatArray, FloatArray]:
    """Gaps (ages, p, C) before each slice of a change, and information (ages, p) after it."""
    C, p, lasts = len(J), len(kind.scale), kind.lasts
    now = Slice(J, np.zeros(C), covariance)
    gaps, told = np.zeros((lasts, p, C)), np.zeros((lasts, p))
    own, alone = np.arange(p), kind._replace(every=lasts)
    changes = no_changes(p, C)
    for age in range(lasts):
        before = changes.gap[0] if age else np.zeros((p, C))
        gaps[age] = np.roll(before, -p, axis=1)
        gaps[age][:, -p:] = before[:, -p:]
        gaps[age][own, C - p + own] += kind.growth if age else kind.growth or 1.0
        changes = next_changes(changes, now, age, alone)
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
    known: Known,
    kept: tuple[tuple[FloatArray, ...], tuple[IntArray, ...]],
    level: float,
    sums: FloatArray,
) -> int:
    """Write the log evidence of each slice; `kept` goes on to the next call."""
    alarms = 0
    for t in range(len(noise)):
        now, whole = first + t, 0.0
        for kind in range(2):
            lead, told, variance = known.lead[kind], known.told[kind], known.variance[kind]
            score, begun, every = kept[0][kind], kept[1][kind], known.every[kind]
            lasts, p, rank = lead.shape
            total = 0.0
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
            whole += total / (2 * p * variance.shape[1])
        sums[t] = np.log(whole) if whole > 0.0 else -np.inf
        if sums[t] > level:
            alarms += 1
            for kind in range(2):
                kept[1][kind][:] = now - len(known.told[kind])
    return alarms
