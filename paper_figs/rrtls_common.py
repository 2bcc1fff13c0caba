"""What the figures of the total-least-squares paper share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from paper_figs.passive_common import (
    PERCENT,
    TOTAL_SOURCE,
    bound_curve,
    curve,
    grid,
    load,
    median_of_bound,
    root_mean,
    root_median,
    runs_of,
    shared_legend,
)
from paper_figs.style import PASSIVE_COLOURS, WIDTH, footnote, save
from probreg.typing import FloatArray

PAPERS = ("RLS", "RTLS", "XRTLS", "RRTLS")


def draw_errors(
    name: str, number: int, condition: str, profile: str, results: Path, out: Path
) -> list[Path]:
    """Figures 2 and 4: relative distance error against the point, root mean square and median."""
    data, manifest = load("rrtls", profile, results)
    point = data["point"].values
    figure, panels = grid(1, 2, 3.4, WIDTH)
    error = {}
    for method in PAPERS:
        square = PERCENT**2 * data["squared_error"].sel(outliers=condition, estimator=method)
        error[method] = root_mean(square)
        curve(panels[0, 0], point, error[method], method)
        curve(panels[0, 1], point, root_median(square), method)
    for axes, title in zip(panels[0], ("root mean square", "median"), strict=True):
        bound_curve(axes, point, PERCENT * median_of_bound(data, "point"))
        axes.set_yscale("log")
        axes.set_ylim(0.3, 200.0)
        axes.set_title(title)
        axes.set_xlabel("point")
    panels[0, 0].set_ylabel("relative distance error (%)")
    shared_legend(figure, panels[0, 0], 5)
    text = f"After Figure {number} of {TOTAL_SOURCE}; {runs_of(manifest)} runs\n"
    if condition == "none":
        text += "Before point 20 the mean square is not finite; the bound is one of mean square."
    else:
        text += f"{order(data, point, error)}; the bound is that of clean bearings."
    footnote(figure, text)
    return save(figure, name, out)


def order(data: xr.Dataset, point: FloatArray, error: dict[str, FloatArray]) -> str:
    """Say where the paper's order RRTLS < XRTLS < RTLS < RLS holds, from the numbers drawn."""
    rows = np.array([error[name] for name in ("RRTLS", "XRTLS", "RTLS", "RLS")])
    holds = (np.diff(rows, axis=0) > 0.0).all(axis=0) & (point > 100)
    if not holds.any():
        return "The order RRTLS < XRTLS < RTLS < RLS holds nowhere after point 100"
    where = point[holds]
    return (
        f"The order RRTLS < XRTLS < RTLS < RLS holds at {len(where)} of the points from "
        f"{where[0]} to {where[-1]}"
    )


def draw_residuals(
    name: str, number: int, condition: str, profile: str, results: Path, out: Path
) -> list[Path]:
    """Figures 3 and 5: histograms of standardised residuals at the last estimate."""
    data, manifest = load("rrtls", profile, results)
    figure, panels = grid(2, 2, 4.4, WIDTH)
    centre = data["bin"].values
    width = centre[1] - centre[0]
    normal = np.exp(-0.5 * centre**2) / np.sqrt(2.0 * np.pi)
    for axes, method in zip(panels.ravel(), PAPERS, strict=True):
        chosen = data.sel(outliers=condition, estimator=method)
        counts = chosen["residual_counts"].sum("case").values
        share = counts / counts.sum() / width
        axes.stairs(share, np.append(centre - width / 2, centre[-1] + width / 2), fill=True,
                    color=PASSIVE_COLOURS[method], alpha=0.6)  # fmt: skip
        axes.plot(centre, normal, color="0.15", linewidth=0.8)
        largest = float(chosen["largest_residual"].mean())
        axes.set_title(f"{method}: largest {largest:.1f} sigma in the mean")
        axes.set_yscale("log")
        axes.set_ylim(1e-5, 2.0)
        axes.set_xlim((-6.0, 6.0) if condition == "none" else (centre[0], centre[-1]))
    for axes in panels[-1]:
        axes.set_xlabel("residual over sigma times the distance")
    for axes in panels[:, 0]:
        axes.set_ylabel("density")
    text = (
        f"After Figure {number} of {TOTAL_SOURCE}; {runs_of(manifest)} runs; line: normal density"
    )
    if condition == "table":
        text += "\nThe paper prints 59.3 (RLS) and 52.4 (RTLS) for the mean largest residual"
    footnote(figure, text)
    return save(figure, name, out)
