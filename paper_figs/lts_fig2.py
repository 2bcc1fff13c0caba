"""LTS paper, Figure 2: the association of one run, both readings."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from experiments.results import load_result
from paper_figs._lts import READINGS, SOURCE
from paper_figs._style import COLOURS, WIDTH, footnote, save, shared_legend


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw reports of A and B with right pairs solid and wrong pairs dashed."""
    figure, panels = plt.subplots(1, 2, figsize=(WIDTH, 3.9))
    for axes, reading in zip(panels, READINGS, strict=True):
        data, _ = load_result("lts_example", f"{profile},reading={reading}", results)
        frame = data.isel(replicate=0)
        first, second = 1e-3 * frame["first"].values, 1e-3 * frame["second"].values
        wrong = frame["wrong"].values.astype(bool)
        for (i, j), bad in zip(frame["pairs"].values, wrong, strict=True):
            axes.plot(*zip(first[i], second[j], strict=True), color="0.2" if not bad else "#C00000",
                      linestyle="--" if bad else "-", linewidth=1.0)  # fmt: skip
        axes.plot(*first.T, "o", color=COLOURS["RLS"], markersize=4, label="report of A")
        axes.plot(*second.T, "s", color=COLOURS["RALAD"], markersize=4, fillstyle="none",
                  label="report of B")  # fmt: skip
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_title(f"{reading} reading: {wrong.sum()} of {wrong.size} pairs wrong")
        axes.set_xlabel("x, east (km)")
    panels[0].set_ylabel("y, north (km)")
    panels[0].plot([], [], color="0.2", label="right pair")
    panels[0].plot([], [], color="#C00000", linestyle="--", label="wrong pair")
    shared_legend(figure, panels[0], 4)
    footnote(figure, f"After Figure 2 of {SOURCE}; one run each, sigma = 100 m")
    return save(figure, "lts_fig2", out)
