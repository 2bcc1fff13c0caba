"""Beyond the bearings-only papers: maximum likelihood under robust laws, a biased sensor."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from paper_figs.passive_common import load, root_mean, root_median, runs_of
from paper_figs.style import BOUND, PASSIVE_COLOURS, WIDTH, footnote, save
from paper_figs.tables import save_table


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw error over bound by number of bearings, one panel a scene; and the table."""
    data, manifest = load("passive_beyond", profile, results)
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
    for axes in panels.ravel()[len(scenes) :]:
        axes.set_axis_off()
        axes.legend(handles.values(), handles.keys(), fontsize=6.5, loc="center")
    for axes in (*panels[1, :3], panels[0, 3]):
        axes.set_xlabel("bearings")
        axes.tick_params(labelbottom=True)
    for axes in panels[:, 0]:
        axes.set_ylabel("RMSE over bound")
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
