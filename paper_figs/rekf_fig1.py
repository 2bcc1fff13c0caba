"""Robust EKF paper, Figure 1: the geometry, and where 200 runs place the emitter."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from paper_figs._cases import load_cases, runs_of
from paper_figs._passive import FILTER_SOURCE, draw_geometry
from paper_figs._style import BOUND, PASSIVE_COLOURS, WIDTH, footnote, save


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the scene, and the last estimates of two methods with the bound's 90 % ellipse."""
    data, manifest = load_cases("rekf", f"{profile},sigma_deg=0.1", results)
    first = data.isel(case=0)
    figure, (scene, zoom) = plt.subplots(1, 2, figsize=(WIDTH, 3.2))
    own, emitter = first["own"].transpose("time", "axis").values, data["emitter"].values
    draw_geometry(scene, own, emitter, first["bearing"].values, [0, 5, 10, 20, 40, 100])
    scene.set_xlim(-3.0, 65.0)
    scene.set_ylim(-1.0, 14.0)
    scene.legend(loc="upper right", fontsize=7)
    scene.set_title("600 m/s along x for 200 s, to x = 120 km")
    values, vectors = np.linalg.eigh(first["bound"].transpose("axis", "axis2").values)
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    ellipse = vectors @ (np.sqrt(4.605 * values)[:, None] * circle)
    for name in ("LS", "EKF", "EKF, start reused"):
        found = data["theta"].sel(outliers="none", estimator=name).transpose("case", "axis").values
        gap = found - emitter
        zoom.plot(*gap.T, ".", color=PASSIVE_COLOURS[name], markersize=3, label=name)
    zoom.plot(*ellipse, **BOUND, label="90 % of the bound")
    zoom.set_aspect("equal", adjustable="datalim")
    zoom.set_xlabel("x - emitter (m)")
    zoom.set_ylabel("y - emitter (m)")
    zoom.set_title("estimates after 200 s, sigma = 0.1 deg")
    zoom.legend(fontsize=7)
    note = f"After Figure 1 of {FILTER_SOURCE}; {runs_of(manifest)} runs without outliers"
    footnote(figure, note)
    return save(figure, "rekf_fig1", out)
