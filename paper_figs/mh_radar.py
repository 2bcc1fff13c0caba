"""Drifting and constant radar biases with outliers and exchanged reports: every method."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from experiments.results import load_result
from paper_figs._errors import ONLINE, WHOLE, error_bars, mean_and_error, rmse
from paper_figs._style import WIDTH, footnote, name_rows, save
from paper_figs._tables import save_table

TITLES = {True: "drifting biases", False: "constant biases"}
UNITS = {"range (m)": ("range",), "angles (mrad)": ("azimuth", "elevation")}


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw error of range and angles, and coverage, drifting above and constant below."""
    figure, grid = plt.subplots(2, 3, figsize=(1.2 * WIDTH, 6.4), sharey=True)
    rows: list[list[str]] = []
    runs = scans = 0
    for panels, (drifting, title) in zip(grid, TITLES.items(), strict=True):
        data, manifest = load_result("mh_radar", f"{profile},drifting={drifting}", results)
        data = data.rename(replicate="case")
        runs, scans = data.sizes["case"], int(manifest["config"]["scans"])
        panels[1].set_title(title)
        rows += [[title], *_row_of_panels(panels, data)]
    note = (
        f"RALAD case 1 in {scans} scans, {runs} runs, after the first ten scans\n"
        "Blue: what was seen so far, red: all scans. Bars: two standard errors. "
        "gamma 10 is no posterior."
    )
    footnote(figure, note)
    paths = save(figure, "mh_radar", out)
    header = ["", "RMSE, range (m)", "RMSE, angles (mrad)", "90 % holds", "seconds"]
    title = "Radar biases with outliers and exchanged reports"
    return paths + save_table("mh_radar_table", title, header, rows, note, out)


def _row_of_panels(panels: np.ndarray, data: xr.Dataset) -> list[list[str]]:
    """Draw one scene and give the rows of the table, a method each."""
    methods = [str(m) for m in data["estimator"].values]
    colours = [WHOLE if m.startswith(("Gibbs", "NUTS")) else ONLINE for m in methods]
    names = [str(p) for p in data["parameter"].values]
    at, cells = np.arange(len(methods)), [[f"  {method}"] for method in methods]
    for axes, (label, kinds) in zip(panels, UNITS.items(), strict=False):
        own = [n for n in names if n.split(".")[-1] in kinds]
        scale = 1e3 if "rad" in label else 1.0
        chosen = data["square"].sel(parameter=own)
        found = scale * np.array([rmse(chosen.sel(estimator=m)) for m in methods])
        error_bars(axes, at, found, colours)
        axes.set_xscale("log")
        axes.set_xlabel(f"RMSE, {label}")
        for row, (value, error) in zip(cells, found, strict=True):
            row.append(f"{value:.3g} ± {error:.1g}")
    shares = np.array([mean_and_error(data["held"].sel(estimator=m)) for m in methods])
    error_bars(panels[2], at, shares, colours)
    panels[2].axvline(0.9, color="0.15", linewidth=1.0, linestyle=":")
    panels[2].set_xlabel("share of 90 % intervals that hold")
    name_rows(panels[0], methods)
    seconds = data["seconds"].median("case")
    for row, method, (share, error) in zip(cells, methods, shares, strict=True):
        row += [f"{share:.3f} ± {error:.3f}", f"{float(seconds.sel(estimator=method)):.2f}"]
    return cells
