"""Falling errors from chains that have not converged: a low-pass filter, not inference."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._cases import load_cases, runs_of
from paper_figs._mh import SOURCE
from paper_figs._style import WIDTH, footnote, save


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the error over time of four chains with a flat prior, and of the Kalman filter."""
    data, manifest = load_cases("mh_sensitivity", profile, results)
    figure, axes = plt.subplots(figsize=(WIDTH, 3.4))
    for k, chain in enumerate(str(c) for c in data["chain"].values):
        square = data["lowpass_square"].sel(chain=chain).mean("case").values
        style = "0.15" if chain == "Kalman filter" else f"C{k}"
        axes.plot(data["time"].values, np.sqrt(square), color=style, label=chain, linewidth=1.1)
    floor = np.sqrt(2.0 * manifest["config"]["scenes"]["False"]["scene"]["noise_variance_m2"])
    axes.axhline(floor, color="0.6", linewidth=0.8, linestyle=":")
    axes.text(181.0, floor, "floor of\none scan", fontsize=7, color="0.4", va="center")
    axes.set_yscale("log")
    axes.set_xlabel("time (s)")
    axes.set_ylabel("RMSE of the bias (m)")
    axes.legend(fontsize=7, ncols=2)
    text = (
        f"Scene of {SOURCE}, form B, constant bias, flat prior, last state of each scan, "
        f"{runs_of(manifest)} runs\nA chain too short to converge remembers the scans before: "
        "it falls below the floor, and is slow to leave its start"
    )
    footnote(figure, text)
    return save(figure, "mh_lowpass", out)
