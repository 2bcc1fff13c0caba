"""Robust EKF paper, Figure 4: the filters with outliers, in both readings of the table."""

from __future__ import annotations

from pathlib import Path

from paper_figs.passive_common import (
    FILTER_SOURCE,
    READING_TITLES,
    SIGMAS,
    bound_curve,
    curve,
    grid,
    load,
    median_of_bound,
    root_mean,
    runs_of,
    shared_legend,
)
from paper_figs.style import WIDTH, footnote, save

SHOWN = ("LS", "EKF", "REKF", "chi2-REKF")


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one row a reading, one column a sigma."""
    readings = ("random", "one_sided")
    figure, panels = grid(len(readings), len(SIGMAS), 5.2, WIDTH)
    for column, sigma in zip(panels.T, SIGMAS, strict=True):
        data, manifest = load("rekf", f"{profile},sigma_deg={sigma}", results)
        time = data["time"].values
        for axes, reading in zip(column, readings, strict=True):
            for name in SHOWN:
                square = data["squared_error"].sel(outliers=reading, estimator=name)
                curve(axes, time, root_mean(square), name)
            bound_curve(axes, time, median_of_bound(data, "time"))
            axes.set_yscale("log")
            axes.set_ylim(50.0 * sigma, 5_000.0 * sigma)
            axes.set_title(f"{READING_TITLES[reading]}, sigma = {sigma} deg")
        column[-1].set_xlabel("time (s)")
    for axes in panels[:, 0]:
        axes.set_ylabel("RMSE of position (m)")
    shared_legend(figure, panels[0, 0], 5)
    note = (
        f"After Figure 4 of {FILTER_SOURCE}; {runs_of(manifest)} runs\n"
        "Outliers at 100-110, 130, 140 and 160 s; the bound is that of clean bearings.\n"
        "The paper's table is titled random; its curves fit outliers to one side and sigma = 1 deg."
    )
    footnote(figure, note)
    return save(figure, "rekf_fig4", out)
