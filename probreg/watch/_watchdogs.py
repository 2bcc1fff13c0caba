"""Sensors that fall silent, and noise that no longer fits: sums of likelihood ratios."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from probreg.noise import ScaleMixture
from probreg.posterior.tracks import Point, judge
from probreg.typing import FloatArray, IntArray
from probreg.watch._refine import NEWEST, Frame, Refined

FACTORS = (0.5, 0.7, 1.25, 1.5, 2.0, 3.0)  # on the noise of a sensor
COMPARED = (1, 2)  # of these, whose scores say whether there is less or more
ALMOST = 0.05  # share of its usual reports that a silent sensor still gives
REMEMBER = 0.98  # of the expected shares of sensors, from slice to slice


def louder(frame: Frame, refined: Refined) -> tuple[FloatArray, IntArray]:
    """Log likelihood ratios (models, factors) of more noise, by the reports of the newest slice.

    And how many reports (models,) these are.
    """
    noise = frame.noise
    found = np.zeros((len(noise.laws), len(FACTORS)))
    if refined.tangent is None or refined.judged is None:
        return found, np.zeros(len(noise.laws), dtype=np.int64)
    assert refined.smoothed is not None
    assert refined.weights is not None
    at, model = refined.tangent.at, refined.tangent.model
    newest = (refined.tangent.group == NEWEST) & refined.judged.placed
    kind = refined.reports.kind[at.rows][newest]
    for k, factor in enumerate(FACTORS):
        laws = tuple(scaled(law, factor) for law in noise.laws)
        point = Point(at, refined.weights, frame.density, laws, noise.wrong, frame.constant_sd)
        there = judge(model, point, refined.smoothed).log_density[newest]
        ratio = there - refined.judged.log_density[newest]
        found[:, k] = np.bincount(kind, ratio, minlength=len(noise.laws))
    return found, np.bincount(kind, minlength=len(noise.laws))


def scaled(law: ScaleMixture, factor: float) -> ScaleMixture:
    """The law with all its noise grown by a factor."""
    return replace(law, **{law.unit_name: law.unit * factor})  # type: ignore[type-var]


def shiryaev_roberts(log_sum: FloatArray, log_ratio: FloatArray) -> FloatArray:
    """Log of (1 + R) ratio: its mean time to a false alarm is at least its threshold."""
    return np.asarray(np.logaddexp(0.0, log_sum) + log_ratio)


def quieter(counts: IntArray, expected: FloatArray) -> FloatArray:
    """Log likelihood ratio (sensors,) of silence, by the counts of the others."""
    share = np.clip(expected, 0.0, 0.999)
    due = share / (1.0 - share) * (counts.sum() - counts)
    return np.asarray(counts * np.log(ALMOST) + (1.0 - ALMOST) * due)


def shares_of(counts: IntArray, expected: FloatArray, speaking: np.ndarray) -> FloatArray:
    """Expected shares of the reports (sensors,), learned while all sensors speak."""
    total = int(counts.sum())
    if not total or not speaking.all():
        return expected
    if not expected.any():
        return np.asarray(counts / total)
    return np.asarray(REMEMBER * expected + (1.0 - REMEMBER) * counts / total)
