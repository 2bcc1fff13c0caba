"""Robust total-least-squares paper, Figures 2-5: distance errors and residuals."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from paper_figs._cases import load_cases, runs_of
from paper_figs._passive import (
    PERCENT,
    TOTAL_SOURCE,
    draw_curves,
    grid,
    root_mean,
    root_median,
)
from paper_figs._style import (
    PASSIVE_COLOURS,
    footnote,
    label_outer,
    save,
    shared_legend,
)
from probreg.typing import FloatArray

PAPERS = ("RLS", "RTLS", "XRTLS", "RRTLS")


def draw_errors(
    profile: str, results: Path, out: Path, *, number: int, condition: str
) -> list[Path]:
    """Figures 2 and 4: relative distance error against the point, root mean square and median."""
    data, manifest = load_cases("rrtls", profile, results)
    figure, panels = grid(1, 2, 3.4)
    chosen = data.sel(outliers=condition)
    error = draw_curves(panels[0, 0], chosen, "point", PAPERS, root_mean, PERCENT)
    draw_curves(panels[0, 1], chosen, "point", PAPERS, root_median, PERCENT)
    for axes, title in zip(panels[0], ("root mean square", "median"), strict=True):
        axes.set_ylim(0.3, 200.0)
        axes.set_title(title)
    label_outer(panels, "point", "relative distance error (%)")
    shared_legend(figure, panels[0, 0], len(PAPERS) + 1)
    text = f"After Figure {number} of {TOTAL_SOURCE}; {runs_of(manifest)} runs\n"
    if condition == "none":
        text += "Before point 20 the mean square is not finite; the bound is one of mean square."
    else:
        text += f"{_order(data['point'].values, error)}; the bound is that of clean bearings."
    footnote(figure, text)
    return save(figure, f"rrtls_fig{number}", out)


def _order(point: FloatArray, error: dict[str, FloatArray]) -> str:
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
    profile: str, results: Path, out: Path, *, number: int, condition: str
) -> list[Path]:
    """Figures 3 and 5: histograms of standardised residuals at the last estimate."""
    data, manifest = load_cases("rrtls", profile, results)
    figure, panels = grid(2, 2, 4.4)
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
    label_outer(panels, "residual over sigma times the distance", "density")
    text = (
        f"After Figure {number} of {TOTAL_SOURCE}; {runs_of(manifest)} runs; line: normal density"
    )
    if condition == "table":
        text += "\nThe paper prints 59.3 (RLS) and 52.4 (RTLS) for the mean largest residual"
    footnote(figure, text)
    return save(figure, f"rrtls_fig{number}", out)


FIGURES = {
    "rrtls_fig2": partial(draw_errors, number=2, condition="none"),
    "rrtls_fig3": partial(draw_residuals, number=3, condition="none"),
    "rrtls_fig4": partial(draw_errors, number=4, condition="table"),
    "rrtls_fig5": partial(draw_residuals, number=5, condition="table"),
}
