"""Metropolis-Hastings paper, Figures 1-8: tracks, biases and errors over time."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._cases import runs_of
from paper_figs._mh import FORM_TITLES, MH_COLOURS, SOURCE, load
from paper_figs._style import TRUTH, WIDTH, footnote, label_outer, save, shared_legend

ROWS = {"paper's protocol": "the paper's protocol", "sequential MH": "sequential inference"}
# what the error is of, and what must be said of it
ERRORS = {
    "bias": (
        "RMSE of the bias (m)",
        "A flat prior for each scan cannot fall below the error of one scan.",
    ),
    "position": (
        "RMSE of a corrected position (m)",
        "A fresh target of the same sensor is scored: the one that gave the bias is not free.",
    ),
}


def draw_tracks(
    profile: str, results: Path, out: Path, *, number: int, drifting: bool
) -> list[Path]:
    """Figures 1 and 5: the track, what is reported, and what is left after correction."""
    data, manifest = load(drifting, profile, results)
    one = data.isel(case=0)
    figure, grid = plt.subplots(2, 2, figsize=(WIDTH, 5.0), sharex=True, sharey=True)
    truth = 1e-3 * one["positions"].transpose("time", "axis").values
    for column, form in zip(grid.T, FORM_TITLES, strict=True):
        reports = 1e-3 * one["example_reports"].sel(form=form).transpose("time", "axis").values
        for axes, method in zip(column, ROWS, strict=True):
            estimate = one["example_estimate"].sel(form=form, estimator=method)
            corrected = reports - 1e-3 * estimate.transpose("time", "axis").values
            axes.plot(*truth.T, **TRUTH, label="true track")
            axes.plot(*reports.T, ".", color="0.6", markersize=2.5, label="reported")
            axes.plot(*corrected.T, ".", color=MH_COLOURS[method], markersize=2.5,
                      label="corrected")  # fmt: skip
            axes.set_title(f"{FORM_TITLES[form]}; {ROWS[method]}", fontsize=8)
    label_outer(grid, "x (km)", "y (km)")
    grid[0, 0].legend(fontsize=7)
    text = "One run; the same reports are corrected that gave the bias."
    footnote(figure, _note(number, drifting, manifest, text))
    return save(figure, f"mh_fig{number}", out)


def draw_bias(profile: str, results: Path, out: Path, *, number: int, drifting: bool) -> list[Path]:
    """Figures 2 and 6: the bias and its estimate over time."""
    data, manifest = load(drifting, profile, results)
    one = data.isel(case=0)
    figure, grid = plt.subplots(2, 2, figsize=(WIDTH, 4.6), sharex=True)
    time = one["time"].values
    for column, form in zip(grid.T, FORM_TITLES, strict=True):
        for axes, method in zip(column, ROWS, strict=True):
            for k, axis in enumerate("xy"):
                chosen = {"form": form, "axis": axis}
                truth = one["example_bias"].sel(chosen).values
                estimate = one["example_estimate"].sel({"estimator": method, **chosen}).values
                axes.plot(time, estimate, color=f"C{k}", linewidth=0.9, label=f"estimate, {axis}")
                axes.plot(time, truth, color=f"C{k}", linestyle="--", label=f"true bias, {axis}")
            axes.set_title(f"{FORM_TITLES[form]}; {ROWS[method]}", fontsize=8)
    label_outer(grid, "time (s)", "bias (m)")
    grid[0, 0].legend(fontsize=7)
    footnote(figure, _note(number, drifting, manifest, "One run."))
    return save(figure, f"mh_fig{number}", out)


def draw_errors(
    profile: str, results: Path, out: Path, *, number: int, drifting: bool, quantity: str
) -> list[Path]:
    """Figures 3, 4, 7 and 8: root mean square error over time, of the bias or of a position."""
    data, manifest = load(drifting, profile, results)
    figure, panels = plt.subplots(1, 2, figsize=(WIDTH, 3.4), sharey=True)
    time = data["time"].values
    square = data[f"{quantity}_square"]
    for axes, form in zip(panels, FORM_TITLES, strict=True):
        for method in (str(m) for m in data["estimator"].values):
            error = np.sqrt(square.sel(form=form, estimator=method).mean("case").values)
            axes.plot(time, error, color=MH_COLOURS[method], label=method, linewidth=1.0)
        axes.set_title(FORM_TITLES[form])
        axes.set_xlabel("time (s)")
        axes.set_yscale("log")
    label, text = ERRORS[quantity]
    panels[0].set_ylabel(label)
    shared_legend(figure, panels[0], 3)
    footnote(figure, _note(number, drifting, manifest, text))
    return save(figure, f"mh_fig{number}", out)


def _note(number: int, drifting: bool, manifest: dict[str, Any], text: str) -> str:
    kind = "drifting" if drifting else "constant"
    return f"After Figure {number} of {SOURCE}\n{kind} bias, {runs_of(manifest)} runs. {text}"


FIGURES = {
    "mh_fig1": partial(draw_tracks, number=1, drifting=True),
    "mh_fig2": partial(draw_bias, number=2, drifting=True),
    "mh_fig3": partial(draw_errors, number=3, drifting=True, quantity="bias"),
    "mh_fig4": partial(draw_errors, number=4, drifting=True, quantity="position"),
    "mh_fig5": partial(draw_tracks, number=5, drifting=False),
    "mh_fig6": partial(draw_bias, number=6, drifting=False),
    "mh_fig7": partial(draw_errors, number=7, drifting=False, quantity="bias"),
    "mh_fig8": partial(draw_errors, number=8, drifting=False, quantity="position"),
}
