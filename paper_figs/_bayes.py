"""What the figures of the Bayesian studies share: colours, ranks, coverage, ECDF panels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from scipy.special import ndtr, ndtri

from probreg.diagnostics import Coverage, Ranks
from probreg.typing import FloatArray, IntArray

LAW_COLOURS = {
    "Gaussian": "#0072B2",
    "Laplace": "#D55E00",
    "Student-t": "#1F78B4",
    "contaminated": "#6A6100",
}
FAMILY_WISE = 1e-3  # false-alarm rate over everything in one figure


def ranks_of(values: IntArray, keep: int) -> Ranks | None:
    """Ranks (cases, q) of one combination; None where it was not run."""
    present = (values >= 0).all(axis=0)
    if not present.any():
        return None
    names = tuple(str(k) for k in np.flatnonzero(present))
    return Ranks(values[:, present], keep, names)


def pooled(found: Sequence[Coverage]) -> float:
    """Share of intervals that hold the truth, over several quantities."""
    return sum(one.held for one in found) / sum(one.trials for one in found)


def sharpened_coverage(probability: float, gamma: FloatArray) -> FloatArray:
    """What a normal posterior to the power of gamma covers where `probability` is claimed."""
    coverage: FloatArray = 2.0 * ndtr(ndtri(0.5 + 0.5 * probability) / np.sqrt(gamma)) - 1.0
    return coverage


def draw_ecdf(axes: Axes, ranks: Ranks, colour: str, alarm: float = 0.05) -> None:
    """ECDF minus uniform of every quantity, the log-likelihood (last) thick, and the band."""
    low, high = ranks.band(alarm)
    points = ranks.points
    axes.fill_between(points, low, high, color="0.88", linewidth=0, step="mid")
    for name in ranks.names:
        z, gap = ranks.ecdf_difference(name)
        last = name == ranks.names[-1]
        axes.plot(z, gap, color=colour, linewidth=1.3 if last else 0.6, alpha=1.0 if last else 0.7)
    axes.axhline(0.0, color="0.6", linewidth=0.6)
    axes.set_xticks([0.0, 1.0])
    axes.tick_params(labelsize=6)


def verdict(p_values: list[float]) -> str:
    """Least p-value over all quantities, and what it means at the family-wise rate."""
    least = min(p_values)
    limit = FAMILY_WISE / len(p_values)
    passed = "all pass" if least >= limit else f"{sum(p < limit for p in p_values)} fail"
    return (
        f"{len(p_values)} quantities; least p = {least:.2g}, limit {limit:.2g} for a family-wise "
        f"false-alarm rate of {FAMILY_WISE:g}: {passed}"
    )
