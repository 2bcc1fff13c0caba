"""Robust EKF paper, Figure 2: the extended Kalman filter against least squares."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from paper_figs.passive_common import (
    FILTER_SOURCE,
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
from probreg.typing import FloatArray

SHOWN = ("LS", "EKF", "EKF, start reused")


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one panel a sigma."""
    figure, panels = grid(1, len(SIGMAS), 3.2, WIDTH)
    said = []
    for axes, sigma in zip(panels[0], SIGMAS, strict=True):
        data, manifest = load("rekf", f"{profile},sigma_deg={sigma}", results)
        time = data["time"].values
        error = {
            name: root_mean(data["squared_error"].sel(outliers="none", estimator=name))
            for name in SHOWN
        }
        for name in SHOWN:
            curve(axes, time, error[name], name)
        bound_curve(axes, time, median_of_bound(data, "time"))
        axes.set_yscale("log")
        axes.set_ylim(50.0 * sigma, 5_000.0 * sigma)
        axes.set_xlabel("time (s)")
        axes.set_title(f"sigma = {sigma} deg")
        said.append(f"{sigma} deg: until {crossing(time, error['LS'], error['EKF']):.0f} s")
    panels[0, 0].set_ylabel("RMSE of position (m)")
    shared_legend(figure, panels[0, 0], 4)
    note = (
        f"After Figure 2 of {FILTER_SOURCE}; {runs_of(manifest)} runs\n"
        f"Least squares is ahead of the filter at first ({'; '.join(said)}): the filter does not "
        "use the five bearings it starts from.\nFiltered again from there, they bring it to the "
        "bound."
    )
    footnote(figure, note)
    return save(figure, "rekf_fig2", out)


def crossing(time: FloatArray, first: FloatArray, second: FloatArray) -> float:
    """Last time at which the first error is below the second."""
    ahead = np.flatnonzero(first < second)
    return float(time[ahead[-1]]) if ahead.size else float("nan")
