"""LTS paper, Figure 1: what a range and an azimuth bias do to a reported position."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from experiments.results import load_result
from paper_figs._lts import SOURCE
from paper_figs._style import COLOURS, WIDTH, footnote, save

SENSOR_COLOURS = {"A": COLOURS["RLS"], "B": COLOURS["RALAD"]}


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the scene and, enlarged, one target."""
    data, _ = load_result("lts_example", f"{profile},reading=symmetric", results)
    frame = data.isel(replicate=0)
    figure, (scene, zoom) = plt.subplots(1, 2, figsize=(WIDTH, 3.4))
    targets = 1e-3 * frame["targets"].values
    centre = targets.mean(axis=0)
    chosen = int(np.argmin(np.linalg.norm(targets - centre, axis=1)))
    scene.plot(*targets.T, "o", color="0.5", markersize=3, label="target")
    for sensor, colour in SENSOR_COLOURS.items():
        place = 1e-3 * frame["sensors"].sel(sensor=sensor).values
        scene.plot(*place, "^", color=colour, markersize=8, label=f"sensor {sensor}", clip_on=False)
        scene.plot(*np.stack([place, targets[chosen]]).T, color=colour, linewidth=0.8)
        points = 1e-3 * frame["displaced"].sel(sensor=sensor).values[:, chosen]
        true, by_range, _, both = points
        zoom.annotate("", by_range, true, arrowprops={"arrowstyle": "->", "color": colour})
        zoom.annotate("", both, by_range, arrowprops={"arrowstyle": "->", "color": colour})
        zoom.plot(*both, "o", color=colour, label=f"reported by {sensor}")
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        for start, end, text in ((true, by_range, "range"), (by_range, both, "azimuth")):
            x, y = 0.5 * (start + end)
            zoom.text(x, y, f"{text} bias", color=colour, fontsize=7, ha="center", bbox=box)
    zoom.plot(*targets[chosen], "k+", markersize=10, label="true position")
    scene.plot(*targets[chosen], "k+", markersize=10)
    for axes in (scene, zoom):
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x, east (km)")
        axes.set_ylabel("y, north (km)")
    zoom.margins(0.25)
    scene.legend(loc="lower center")
    zoom.legend(fontsize=7)
    zoom.set_title("one target, enlarged")
    footnote(figure, f"After Figure 1 of {SOURCE}; +1 km, +1 deg at A, the opposite at B, no noise")
    return save(figure, "lts_fig1", out)
