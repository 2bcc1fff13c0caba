"""Robust total-least-squares paper, Figure 6: error against the share of outliers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from paper_figs._cases import load_cases, runs_of
from paper_figs._passive import PERCENT, TOTAL_SOURCE, curve, grid, root_bound
from paper_figs._style import BOUND, footnote, save, shared_legend

LIMIT = 5.0  # percent, the accuracy that the paper asks for


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw mean, median and the share of runs beyond the limit."""
    data, manifest = load_cases("rrtls", profile, results)
    rate = 100.0 * data["rate"].values
    figure, panels = grid(1, 3, 3.2)
    mean_axes, median_axes, share_axes = panels[0]
    failed = {}
    for method in (str(m) for m in data["swept"].values):
        square = data["sweep_squared_error"].sel(swept=method).transpose("case", "rate").values
        error = PERCENT * np.sqrt(square)
        curve(mean_axes, rate, error.mean(axis=0), method, marker=".")
        curve(median_axes, rate, np.median(error, axis=0), method, marker=".")
        share = 100.0 * (error > LIMIT).mean(axis=0)
        curve(share_axes, rate, share, method, marker=".")
        failed[method] = float(share[np.argmin(np.abs(rate - 13.0))])
    bound = PERCENT * root_bound(data, "point")[-1]
    for axes, title in ((mean_axes, "mean error"), (median_axes, "median error")):
        axes.set_yscale("log")
        axes.set_ylim(0.3, 60.0)
        axes.axhline(LIMIT, color="0.6", linewidth=0.8)
        axes.axhline(bound, label="Cramér-Rao bound, no outliers", **BOUND)
        axes.set_title(title)
    share_axes.set_title(f"runs beyond {LIMIT:.0f} %")
    mean_axes.set_ylabel("relative distance error at point 200 (%)")
    share_axes.set_ylabel("share of runs (%)")
    for axes in panels[0]:
        axes.set_xlabel("share of outliers (%)")
    shared_legend(figure, mean_axes, 3)
    text = (
        f"After Figure 6 of {TOTAL_SOURCE}; {runs_of(manifest)} runs; outliers of -40 sigma at "
        "random points\nThe paper has RRTLS good at 13 %; here "
        f"{failed['RRTLS']:.0f} % of its runs are off by then, "
        f"{failed['RRTLS, robust start']:.0f} % with a robust start"
    )
    footnote(figure, text)
    return save(figure, "rrtls_fig6", out)
