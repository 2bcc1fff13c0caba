"""What gamma buys and what it costs: sharpness of the draws against calibration."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._bayes import sharpened_coverage
from paper_figs._cases import load_cases, runs_of
from paper_figs._errors import mean_and_error, rmse
from paper_figs._mh import SOURCE, TARGET_COLOURS
from paper_figs._style import BOUND, WIDTH, footnote, save


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw coverage and error against gamma, with the theory of one scan."""
    data, manifest = load_cases("mh_sensitivity", profile, results)
    own = np.flatnonzero(data["factor"].values == "gamma")
    gamma = data["value"].isel(case=0).values[own]
    figure, panels = plt.subplots(1, 2, figsize=(WIDTH, 3.0))
    dense = np.geomspace(gamma.min(), gamma.max(), 100)
    panels[0].plot(dense, sharpened_coverage(0.9, dense), **BOUND, label="one scan, theory")
    for target, colour in TARGET_COLOURS.items():
        chosen = data.sel(target=target).isel(setting=own)
        kinds = {"held": mean_and_error, "square": rmse}
        for axes, (kind, measure) in zip(panels, kinds.items(), strict=True):
            found = [measure(chosen[kind].isel(setting=k)) for k in range(len(own))]
            mean, error = np.array(found).T
            axes.errorbar(gamma, mean, 2.0 * error, fmt="o-", markersize=4, color=colour,
                          capsize=2, label=target)  # fmt: skip
    panels[0].axhline(0.9, color="0.6", linewidth=0.8)
    panels[0].set_ylabel("90 % intervals hold the bias")
    panels[1].set_ylabel("RMSE of the bias (m)")
    for axes in panels:
        axes.set_xscale("log")
        axes.set_xlabel("gamma")
    panels[0].legend(fontsize=7)
    text = (
        f"Scene of {SOURCE}, form B, drifting bias, {runs_of(manifest)} runs; two standard errors\n"
        "gamma other than 1 narrows (or widens) the draws and does not lower the error"
    )
    footnote(figure, text)
    return save(figure, "mh_gamma", out)
