"""The MH tracker's settings, one at a time."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._cases import load_cases, runs_of
from paper_figs._mh import SOURCE, TARGET_COLOURS
from paper_figs._style import WIDTH, footnote, save

LABELS = {
    "share_global": "beta, share of global proposals",
    "gamma": "gamma",
    "step": "step (m)",
    "steps": "proposals a scan",
    "warm_start": "warm start",
}
ROWS = {
    "square": "RMSE of the bias (m)",
    "held": "90 % intervals hold",
    "effective": "effective share of draws",
}


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw error, coverage and efficiency against each setting."""
    data, manifest = load_cases("mh_sensitivity", profile, results)
    figure, grid = plt.subplots(len(ROWS), len(LABELS), figsize=(1.3 * WIDTH, 5.2), sharey="row")
    factor = data["factor"].values
    for c, (name, label) in enumerate(LABELS.items()):
        own = np.flatnonzero(factor == name)
        value = data["value"].isel(case=0).values[own]
        for r, (kind, title) in enumerate(ROWS.items()):
            axes = grid[r, c]
            for target, colour in TARGET_COLOURS.items():
                mean = data[kind].sel(target=target).isel(setting=own).mean("case").values
                shown = np.sqrt(mean) if kind == "square" else mean
                axes.plot(value, shown, "o-", markersize=3, color=colour, label=target)
            if name in ("gamma", "step", "steps"):
                axes.set_xscale("log")
            if kind == "held":
                axes.axhline(0.9, color="0.15", linewidth=1.0, linestyle=":")
            if c == 0:
                axes.set_ylabel(title)
            if r == len(ROWS) - 1:
                axes.set_xlabel(label)
    for axes in grid[:, -1]:
        axes.set_xticks([0.0, 1.0], ["no", "yes"])
    grid[0, 0].legend(fontsize=7)
    text = (
        f"Scene of {SOURCE}, form B, drifting bias, {runs_of(manifest)} runs\n"
        "Otherwise beta = 0.1, gamma = 1, 1000 proposals, step from the posterior's covariance, "
        "warm start from (-1000, -1000) m"
    )
    footnote(figure, text)
    return save(figure, "mh_sensitivity", out)
