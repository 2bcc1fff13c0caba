"""Robust EKF paper, Figure 3: the filters without outliers."""

from __future__ import annotations

from pathlib import Path

from paper_figs.passive_common import (
    FILTER_SOURCE,
    SIGMAS,
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
from paper_figs.style import WIDTH, footnote, save

FILTERS = ("EKF", "REKF", "chi2-REKF", "EKF, start reused")


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw RMSE and median error, one column a sigma."""
    figure, panels = grid(2, len(SIGMAS), 5.0, WIDTH)
    for column, sigma in zip(panels.T, SIGMAS, strict=True):
        data, manifest = load("rekf", f"{profile},sigma_deg={sigma}", results)
        time = data["time"].values
        for name in FILTERS:
            square = data["squared_error"].sel(outliers="none", estimator=name)
            curve(column[0], time, root_mean(square), name)
            curve(column[1], time, root_median(square), name)
        for axes in column:
            bound_curve(axes, time, median_of_bound(data, "time"))
            axes.set_yscale("log")
            axes.set_ylim(50.0 * sigma, 3_000.0 * sigma)
        column[0].set_title(f"sigma = {sigma} deg")
        column[1].set_xlabel("time (s)")
    panels[0, 0].set_ylabel("RMSE of position (m)")
    panels[1, 0].set_ylabel("median error (m)")
    shared_legend(figure, panels[0, 0], 5)
    note = (
        f"After Figure 3 of {FILTER_SOURCE}; {runs_of(manifest)} runs. Before 30 s a few runs "
        "that reject their\nfirst good bearings decide the RMSE of the robust filter. The bound is "
        "one of RMSE; a median lies below it."
    )
    footnote(figure, note)
    return save(figure, "rekf_fig3", out)
