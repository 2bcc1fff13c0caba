"""What the figures of the Metropolis-Hastings paper share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from experiments.results import load_result
from paper_figs.style import TRUTH, WIDTH, footnote, save

SOURCE = "Zhou, Liang and Pan, Systems Engineering and Electronics 34(3), 2012"
FORM_TITLES = {"reference": "B: target known", "pair": "C: second, calibrated sensor"}
ROWS = {"paper's protocol": "the paper's protocol", "sequential MH": "sequential inference"}
MH_COLOURS = {
    "uncorrected": "#888888",
    "paper's protocol": "#D55E00",
    "flat prior, chain mean": "#E69F00",
    "sequential MH": "#0072B2",
    "Kalman filter": "#009E73",
    "RTS smoother": "#CC79A7",
}


def load(drifting: bool, profile: str, results: Path) -> tuple[xr.Dataset, dict[str, Any]]:
    """Results with blocks and runs joined to one dimension "case"."""
    data, manifest = load_result("mh", f"{profile},drifting={drifting}", results)
    return data.stack(case=("replicate", "run"), create_index=False), manifest


def note(number: int, drifting: bool, manifest: dict[str, Any], text: str) -> str:
    """Footnote: where the numbers come from."""
    config = manifest["config"]
    kind = "drifting" if drifting else "constant"
    runs = config["replicates"] * config["runs"]
    return f"After Figure {number} of {SOURCE}\n{kind} bias, {runs} runs. {text}"


def draw_tracks(
    name: str, number: int, drifting: bool, profile: str, results: Path, out: Path
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
    for axes in grid[-1]:
        axes.set_xlabel("x (km)")
    for axes in grid[:, 0]:
        axes.set_ylabel("y (km)")
    grid[0, 0].legend(fontsize=7)
    text = "One run; the same reports are corrected that gave the bias."
    footnote(figure, note(number, drifting, manifest, text))
    return save(figure, name, out)


def draw_bias(
    name: str, number: int, drifting: bool, profile: str, results: Path, out: Path
) -> list[Path]:
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
    for axes in grid[-1]:
        axes.set_xlabel("time (s)")
    for axes in grid[:, 0]:
        axes.set_ylabel("bias (m)")
    grid[0, 0].legend(fontsize=7)
    footnote(figure, note(number, drifting, manifest, "One run."))
    return save(figure, name, out)


def draw_errors(
    name: str,
    number: int,
    drifting: bool,
    quantity: str,
    profile: str,
    results: Path,
    out: Path,
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
    label = "RMSE of the bias (m)" if quantity == "bias" else "RMSE of a corrected position (m)"
    panels[0].set_ylabel(label)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    text = "A flat prior for each scan cannot fall below the error of one scan."
    if quantity == "position":
        text = (
            "A fresh target of the same sensor is scored: the one that gave the bias is not free."
        )
    footnote(figure, note(number, drifting, manifest, text))
    return save(figure, name, out)
