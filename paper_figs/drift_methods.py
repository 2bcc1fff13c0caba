"""Target and drifting bias together: errors and coverage of every method, two noise laws."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._cases import load_cases
from paper_figs._errors import ONLINE, WHOLE, error_bars, mean_and_error, rmse
from paper_figs._style import WIDTH, footnote, name_rows, save
from paper_figs._tables import save_table

NOISES = ("Gaussian", "Student-t")


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one row of panels a noise law, and write the table."""
    figure, grid = plt.subplots(2, 2, figsize=(WIDTH, 5.6), sharey=True)
    rows: list[list[str]] = []
    runs = 0
    for panels, noise in zip(grid, NOISES, strict=True):
        data, _ = load_cases("drift_methods", f"{profile},noise={noise}", results)
        methods, runs = [str(m) for m in data["estimator"].values], data.sizes["case"]
        colours = [ONLINE if past else WHOLE for past in data["past_only"].isel(case=0).values]
        at = np.arange(len(methods))
        errors = [rmse(data["square"].sel(estimator=m)) for m in methods]
        shares = [mean_and_error(data["held"].sel(estimator=m)) for m in methods]
        error_bars(panels[0], at, np.array(errors), colours)
        error_bars(panels[1], at, np.array(shares), colours)
        name_rows(panels[0], methods)
        panels[1].axvline(0.9, color="0.15", linewidth=1.0, linestyle=":")
        panels[0].set_title(f"{noise} noise")
        rows.append([f"{noise} noise"])
        seconds = data["seconds"].median("case")
        for method, (value, error), (share, own) in zip(methods, errors, shares, strict=True):
            cells = [f"{value:.1f} ± {error:.1f}", f"{share:.3f} ± {own:.3f}"]
            rows.append([f"  {method}", *cells, f"{float(seconds.sel(estimator=method)):.3f}"])
    grid[1, 0].set_xlabel("RMSE of the bias (m)")
    grid[1, 1].set_xlabel("share of 90 % intervals that hold the bias")
    note = (
        f"{runs} runs of 60 scans drawn from the model; blue: what was seen so far, red: all scans"
        "\nBars: two standard errors. Kalman and RTS are exact under Gaussian noise only."
    )
    footnote(figure, note)
    paths = save(figure, "drift_methods", out)
    header = ["", "RMSE of the bias (m)", "90 % holds", "seconds"]
    title = "Target and drifting bias together"
    return paths + save_table("drift_methods_table", title, header, rows, note, out)
