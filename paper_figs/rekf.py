"""Robust EKF paper, Figures 2-4: error of position against time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from paper_figs._cases import load_cases, runs_of
from paper_figs._passive import (
    FILTER_SOURCE,
    READING_TITLES,
    SIGMAS,
    draw_curves,
    grid,
    root_mean,
    root_median,
)
from paper_figs._style import footnote, save, shared_legend
from probreg.typing import FloatArray


class Row(NamedTuple):
    """One row of panels: which outliers, which error, and how the panels are named."""

    outliers: str
    measure: Callable[[xr.DataArray], FloatArray]
    ylabel: str
    title: str


class Shown(NamedTuple):
    """What one figure shows; `top` is that of the y axis at 1 deg, the remark is made of data."""

    rows: tuple[Row, ...]
    methods: tuple[str, ...]
    height: float
    top: float
    remark: Callable[[Mapping[float, xr.Dataset]], str]


def draw_errors(profile: str, results: Path, out: Path, *, number: int, shown: Shown) -> list[Path]:
    """Draw one column a sigma."""
    loaded = {s: load_cases("rekf", f"{profile},sigma_deg={s}", results) for s in SIGMAS}
    figure, panels = grid(len(shown.rows), len(SIGMAS), shown.height)
    for column, (sigma, (data, _)) in zip(panels.T, loaded.items(), strict=True):
        for axes, row in zip(column, shown.rows, strict=True):
            draw_curves(axes, data.sel(outliers=row.outliers), "time", shown.methods, row.measure)
            axes.set_ylim(50.0 * sigma, shown.top * sigma)
            axes.set_title(row.title.format(sigma=sigma))
        column[-1].set_xlabel("time (s)")
    for axes, row in zip(panels[:, 0], shown.rows, strict=True):
        axes.set_ylabel(row.ylabel)
    shared_legend(figure, panels[0, 0], len(shown.methods) + 1)
    runs = runs_of(loaded[SIGMAS[0]][1])
    said = shown.remark({sigma: data for sigma, (data, _) in loaded.items()})
    footnote(figure, f"After Figure {number} of {FILTER_SOURCE}; {runs} runs{said}")
    return save(figure, f"rekf_fig{number}", out)


def _least_squares_ahead(loaded: Mapping[float, xr.Dataset]) -> str:
    said = []
    for sigma, data in loaded.items():
        square = data["squared_error"].sel(outliers="none")
        first, second = (root_mean(square.sel(estimator=name)) for name in ("LS", "EKF"))
        ahead = np.flatnonzero(first < second)
        until = float(data["time"][ahead[-1]]) if ahead.size else float("nan")
        said.append(f"{sigma} deg: until {until:.0f} s")
    return (
        f"\nLeast squares is ahead of the filter at first ({'; '.join(said)}): the filter does not "
        "use the five bearings it starts from.\nFiltered again from there, they bring it to the "
        "bound."
    )


def _early_rejections(_: Mapping[float, xr.Dataset]) -> str:
    return (
        ". Before 30 s a few runs that reject their\n"
        "first good bearings decide the RMSE of the robust filter. The bound is "
        "one of RMSE; a median lies below it."
    )


def _where_outliers_are(_: Mapping[float, xr.Dataset]) -> str:
    return (
        "\nOutliers at 100-110, 130, 140 and 160 s; the bound is that of clean bearings.\n"
        "The paper's table is titled random; its curves fit outliers to one side and sigma = 1 deg."
    )


RMSE, SIGMA = "RMSE of position (m)", "sigma = {sigma} deg"
FIGURES = {
    "rekf_fig2": partial(
        draw_errors,
        number=2,
        shown=Shown(
            rows=(Row("none", root_mean, RMSE, SIGMA),),
            methods=("LS", "EKF", "EKF, start reused"),
            height=3.2,
            top=5_000.0,
            remark=_least_squares_ahead,
        ),
    ),
    "rekf_fig3": partial(
        draw_errors,
        number=3,
        shown=Shown(
            rows=(
                Row("none", root_mean, RMSE, SIGMA),
                Row("none", root_median, "median error (m)", ""),
            ),
            methods=("EKF", "REKF", "chi2-REKF", "EKF, start reused"),
            height=5.0,
            top=3_000.0,
            remark=_early_rejections,
        ),
    ),
    "rekf_fig4": partial(
        draw_errors,
        number=4,
        shown=Shown(
            rows=tuple(
                Row(reading, root_mean, RMSE, f"{READING_TITLES[reading]}, {SIGMA}")
                for reading in ("random", "one_sided")
            ),
            methods=("LS", "EKF", "REKF", "chi2-REKF"),
            height=5.2,
            top=5_000.0,
            remark=_where_outliers_are,
        ),
    ),
}
