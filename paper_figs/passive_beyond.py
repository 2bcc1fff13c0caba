"""Beyond the bearings-only papers: maximum likelihood under robust laws, a biased sensor."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from paper_figs._cases import load_cases, runs_of
from paper_figs._passive import root_mean, root_median
from paper_figs._style import BOUND, PASSIVE_COLOURS, WIDTH, footnote, label_outer, save
from paper_figs._tables import save_table


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw error over bound by number of bearings, one panel a scene; and the table."""
    data, manifest = load_cases("passive_beyond", profile, results)
    scenes = [str(s) for s in data["scene"].values]
    figure, panels = plt.subplots(2, 4, figsize=(WIDTH, 4.8), sharex=True, sharey=True)
    handles: dict[str, Any] = {}
    for axes, scene in zip(panels.ravel(), scenes, strict=False):
        bound = bounds(data, scene)
        for name in asked(data, scene):
            square = data["squared_error"].sel(scene=scene, estimator=name)
            style: dict[str, Any] = {"color": PASSIVE_COLOURS[name], "marker": "."}
            ratio = root_mean(square) / bound
            (handles[name],) = axes.plot(data["bearings"].values, ratio, **style, label=name)
        axes.axhline(1.0, **BOUND)
        axes.set_yscale("log")
        axes.set_ylim(0.8, 30.0)
        axes.set_title(scene.replace(", ", ",\n", 1), fontsize=8)
    label_outer(panels, "bearings", "RMSE over bound", len(scenes))
    panels[-1, -1].legend(handles.values(), handles.keys(), fontsize=6.5, loc="center")
    config = manifest["config"]
    text = (
        f"{runs_of(manifest)} runs. The bound is that of the bearings that are no outliers; where "
        f"the sensor is biased ({config['bias_deg']} deg), of position and bias.\n"
        "Where no point is drawn, a run had no estimate or the error is beyond the axis."
    )
    footnote(figure, text)
    return save(figure, "passive_beyond", out) + _table(data, scenes, text, out)


def asked(data: xr.Dataset, scene: str) -> list[str]:
    """Estimators that were run on a scene."""
    square = data["squared_error"].sel(scene=scene)
    return [str(n) for n in data["estimator"].values if square.sel(estimator=n).notnull().any()]


def bounds(data: xr.Dataset, scene: str) -> np.ndarray:
    """Bound by number of bearings: with the bias as unknown where the sensor has one."""
    unknown = "position and bias" if scene.endswith("biased") else "position"
    chosen = data["squared_bound"].isel(case=0).sel(scene=scene, unknown=unknown)
    return np.sqrt(chosen.transpose("bearings").values)


def _table(data: xr.Dataset, scenes: list[str], note: str, out: Path) -> list[Path]:
    rows: list[list[str]] = []
    for scene in scenes:
        bound = bounds(data, scene)
        rows.append([f"{scene}: bound {bound[-1]:.4g} m"])
        for name in asked(data, scene):
            chosen = data.sel(scene=scene, estimator=name).isel(bearings=-1)
            square = chosen["squared_error"]
            cells = [f"{float(f(square)):.4g}" for f in (root_mean, root_median)]
            ratio = f"{float(root_mean(square)) / bound[-1]:.2f}"
            held = chosen["inside"].mean("case")
            rows.append([f"  {name}", *cells, ratio, f"{float(held):.2f}"])
    header = ["after 200 bearings", "RMSE (m)", "median (m)", "RMSE / bound", "90 % ellipse holds"]
    title = "Maximum likelihood beside the papers' estimators"
    return save_table("passive_beyond_table", title, header, rows, note, out)
