"""Coverage of credible intervals against the sharpening exponent, with the theory."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._bayes import sharpened_coverage
from paper_figs._cases import load_cases
from paper_figs._style import TRUTH, WIDTH, footnote, save
from probreg.diagnostics import Coverage


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw both probabilities with Clopper-Pearson intervals of the mean over unknowns."""
    data, _ = load_cases("coverage_by_gamma", profile, results)
    gammas = data["gamma"].values.astype(float)
    unknowns, runs = int(np.ravel(data["unknowns"].values)[0]), data.sizes["case"]
    figure, axes = plt.subplots(figsize=(0.7 * WIDTH, 3.4))
    line = np.geomspace(gammas[0], gammas[-1], 200)
    for k, probability in enumerate(float(p) for p in data["probability"].values):
        axes.plot(line, sharpened_coverage(probability, line), **TRUTH)
        for gamma in gammas:
            held = int(data["held"].sel(gamma=gamma, probability=probability).sum())
            found = Coverage(held, runs * unknowns, probability)
            low, high = found.confidence()
            axes.errorbar(gamma, found.value, [[found.value - low], [high - found.value]],
                          fmt="o", color=f"C{k}", capsize=3)  # fmt: skip
        axes.axhline(probability, color=f"C{k}", linewidth=0.8)
        axes.annotate(f"claimed {probability:.0%}", (gammas[-1], probability), fontsize=7,
                      ha="right", va="bottom", color=f"C{k}")  # fmt: skip
    axes.plot([], [], **TRUTH, label=r"$2\Phi(z/\sqrt{\gamma})-1$")
    axes.set_xscale("log")
    axes.set_xticks(gammas, [f"{g:g}" for g in gammas])
    axes.set_xlabel("gamma")
    axes.set_ylabel("share of intervals that hold the truth")
    axes.legend()
    footnote(
        figure,
        f"{runs} runs, {unknowns} biases of a pair of 2-D radars, truth from the prior\n"
        "Only gamma = 1 is a posterior; bars: 95 %",
    )
    return save(figure, "coverage_by_gamma", out)
