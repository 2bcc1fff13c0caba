"""What gamma buys and what it costs: sharpness of the draws against calibration."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ndtr, ndtri

from paper_figs.bayes_common import load_ranks
from paper_figs.mh_common import SOURCE
from paper_figs.mh_sensitivity import COLOURS
from paper_figs.style import BOUND, WIDTH, footnote, save


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw coverage and error against gamma, with the theory of one scan."""
    data, manifest = load_ranks("mh_sensitivity", profile, results)
    own = np.flatnonzero(data["factor"].values == "gamma")
    gamma = data["value"].isel(case=0).values[own]
    figure, panels = plt.subplots(1, 2, figsize=(WIDTH, 3.0))
    dense = np.geomspace(gamma.min(), gamma.max(), 100)
    theory = 2.0 * ndtr(ndtri(0.95) / np.sqrt(dense)) - 1.0
    panels[0].plot(dense, theory, **BOUND, label="one scan, theory")
    for target, colour in COLOURS.items():
        chosen = data.sel(target=target).isel(setting=own)
        for axes, kind in zip(panels, ("held", "square"), strict=True):
            values = chosen[kind].transpose("setting", "case").values
            mean = values.mean(axis=1)
            error = values.std(axis=1) / np.sqrt(values.shape[1])
            if kind == "square":
                mean, error = np.sqrt(mean), error / (2.0 * np.sqrt(mean))
            axes.errorbar(gamma, mean, 2.0 * error, fmt="o-", markersize=4, color=colour,
                          capsize=2, label=target)  # fmt: skip
    panels[0].axhline(0.9, color="0.6", linewidth=0.8)
    panels[0].set_ylabel("90 % intervals hold the bias")
    panels[1].set_ylabel("RMSE of the bias (m)")
    for axes in panels:
        axes.set_xscale("log")
        axes.set_xlabel("gamma")
    panels[0].legend(fontsize=7)
    config = manifest["config"]
    runs = config["replicates"] * config["runs"]
    text = f"Scene of {SOURCE}, form B, drifting bias, {runs} runs; two standard errors\n"
    text += "gamma other than 1 narrows (or widens) the draws and does not lower the error"
    footnote(figure, text)
    return save(figure, "mh_gamma", out)
