"""Drifting and constant radar biases with outliers and exchanged reports: every method."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from experiments.results import load_result
from paper_figs.drift_common import ONLINE, WHOLE, error_bars, rmse
from paper_figs.style import WIDTH, footnote, save
from paper_figs.tables import save_table

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
        methods, runs = [str(m) for m in data["estimator"].values], data.sizes["case"]
        colours = [WHOLE if m.startswith(("Gibbs", "NUTS")) else ONLINE for m in methods]
        names = [str(p) for p in data["parameter"].values]
        at, columns = np.arange(len(methods)), []
        for axes, (label, kinds) in zip(panels, UNITS.items(), strict=False):
            own = [n for n in names if n.split(".")[-1] in kinds]
            scale = 1e3 if "rad" in label else 1.0
            chosen = data["square"].sel(parameter=own)
            found = scale * np.array([rmse(chosen.sel(estimator=m)) for m in methods])
            error_bars(axes, at, found, colours)
            axes.set_xscale("log")
            axes.set_xlabel(f"RMSE, {label}")
            columns.append([f"{value:.3g} ± {error:.1g}" for value, error in found])
        held = data["held"].mean("parameter").transpose("case", "estimator").values
        shares = np.stack([held.mean(axis=0), held.std(axis=0) / np.sqrt(runs)], axis=1)
        error_bars(panels[2], at, shares, colours)
        panels[2].axvline(0.9, color="0.15", linewidth=1.0, linestyle=":")
        panels[2].set_xlabel("share of 90 % intervals that hold")
        panels[0].set_yticks(at, methods, fontsize=7)
        panels[1].set_title(title)
        scans = int(manifest["config"]["scans"])
        seconds = data["seconds"].median("case")
        rows.append([title])
        for k, method in enumerate(methods):
            spent = f"{float(seconds.sel(estimator=method)):.2f}"
            shown = f"{shares[k, 0]:.3f} ± {shares[k, 1]:.3f}"
            rows.append([f"  {method}", columns[0][k], columns[1][k], shown, spent])
    grid[0, 0].invert_yaxis()
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
