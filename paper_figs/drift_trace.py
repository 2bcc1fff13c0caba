"""Posterior bands of a drifting bias over time, with the truth drawn in."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from paper_figs._cases import load_cases
from paper_figs._style import TRUTH, WIDTH, footnote, label_outer, save

SHOWN = ("Kalman filter", "particle filter", "RTS smoother", "Gibbs")


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw mean and 90 % band of four methods under Student-t noise."""
    data, _ = load_cases("drift_methods", f"{profile},noise=Student-t", results)
    one = data.isel(case=0)
    time = one["time"].values
    figure, grid = plt.subplots(2, 2, figsize=(WIDTH, 4.4), sharex=True, sharey=True)
    for axes, method in zip(grid.ravel(), SHOWN, strict=True):
        for k, axis in enumerate("xy"):
            band = one["example"].sel(estimator=method, axis=axis)
            low, high = (band.sel(bound=b).values for b in ("low", "high"))
            axes.fill_between(time, low, high, color=f"C{k}", alpha=0.25, linewidth=0)
            axes.plot(time, band.sel(bound="mean").values, color=f"C{k}", label=f"mean, {axis}")
            truth = one["example_truth"].sel(axis=axis).values
            axes.plot(time, truth, **{**TRUTH, "label": "truth" if k else None})
        axes.set_title(method)
    label_outer(grid, "time (s)", "bias (m)")
    grid[0, 0].legend(fontsize=7)
    text = (
        "One run, Student-t noise of nu = 4 along each axis. Bands: 90 %.\nAbove: what was seen "
        "so far; Kalman filter and smoother take the noise for Gaussian."
    )
    footnote(figure, text)
    return save(figure, "drift_trace", out)
