"""Robust total-least-squares paper, Figure 1: the geometry."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._cases import load_cases
from paper_figs._passive import TOTAL_SOURCE, draw_geometry
from paper_figs._style import WIDTH, footnote, save


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the scene to scale."""
    data, _ = load_cases("rrtls", profile, results)
    first = data.isel(case=0)
    own, emitter = first["own"].transpose("point", "axis").values, data["emitter"].values
    away = emitter - own
    bearings = np.arctan2(away[:, 1], away[:, 0])
    figure, axes = plt.subplots(figsize=(0.55 * WIDTH, 4.4))
    draw_geometry(axes, own, emitter, bearings, [0, 50, 100, 150, 199])
    for line in axes.lines:
        if line.get_label() == "line of sight, as reported":
            line.set_label("line of sight")
    axes.set_aspect("equal")
    axes.set_xlim(-45.0, 100.0)
    axes.set_ylim(-10.0, 200.0)
    axes.legend(loc="lower left", fontsize=7)
    turned = np.rad2deg(np.ptp(bearings))
    footnote(
        figure, f"After Figure 1 of {TOTAL_SOURCE}\n200 bearings; they turn by {turned:.0f} deg"
    )
    return save(figure, "rrtls_fig1", out)
