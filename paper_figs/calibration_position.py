"""Calibration of an emitter's position from bearings, and one posterior on a grid."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from paper_figs._bayes import draw_ecdf, verdict
from paper_figs._cases import load_cases
from paper_figs._style import PASSIVE_COLOURS, WIDTH, footnote, save
from paper_figs._tables import save_table
from probreg.diagnostics import Coverage, Ranks


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the example, and ECDF differences of each sampler; a table of coverage."""
    data, manifest = load_cases("calibration_position", profile, results)
    laws = [str(s) for s in data["law"].values]
    samplers = [str(s) for s in data["sampler"].values]
    names = tuple(str(q) for q in data["quantity"].values)
    keep, runs = int(manifest["config"]["keep"]), data.sizes["case"]
    figure = plt.figure(figsize=(WIDTH, 4.6))
    parts: Any = figure.subfigures(1, 2, width_ratios=[1.0, 1.35])
    left, right = parts
    _example(left.subplots(), data)
    grid = right.subplots(len(samplers), len(laws), sharex=True, sharey=True)
    rows, p_values = [], []
    for r, sampler in enumerate(samplers):
        for c, law in enumerate(laws):
            chosen = data["ranks"].sel(sampler=sampler, law=law)
            ranks = Ranks(chosen.transpose("case", "quantity").values, keep, names)
            draw_ecdf(grid[r, c], ranks, f"C{r}")
            p_values += [float(p) for p in ranks.p_values]
            pooled = [ranks.coverage(p)[:2] for p in (0.5, 0.9)]
            cells = [f"{np.mean([c.value for c in part]):.3f}" for part in pooled]
            rows.append([f"{sampler}: {law}", f"{ranks.p_values.min():.3g}", *cells])
            if r == 0:
                grid[r, c].set_title(law, fontsize=7)
        grid[r, 0].set_ylabel(sampler, fontsize=7)
    for law in laws:
        inside = data["laplace_inside"].sel(law=law)
        cells = []
        for p in (float(x) for x in data["probability"].values):
            held = Coverage(int(inside.sel(probability=p).sum()), runs, p)
            cells.append(f"{held.value:.3f}")
        rows.append([f"Laplace ellipse: {law}", "-", *cells])
    text = f"{runs} runs, 12 bearings of 1 deg, prior 2 km; 95 % bands\n{verdict(p_values)}"
    footnote(figure, text)
    paths = save(figure, "calibration_position", out)
    header = ["", "least p", "50 % holds", "90 % holds"]
    title = "Position from bearings: the exact posterior and the Laplace ellipse"
    return paths + save_table("calibration_position_table", title, header, rows, text, out)


def _example(axes: plt.Axes, data: xr.Dataset) -> None:
    """One posterior: density on a grid, draws, and the Laplace ellipse."""
    one = data.isel(case=0)
    x, y = 1e-3 * one["grid_x"].values, 1e-3 * one["grid_y"].values
    log_density = one["log_density"].transpose("grid_i", "grid_j").values
    weight = np.sort(np.exp(log_density).ravel())
    held = 1.0 - np.cumsum(weight) / weight.sum()
    levels = sorted(np.log(weight[np.searchsorted(-held, -p)]) for p in (0.5, 0.9))
    axes.contour(x, y, log_density.T, levels=levels, colors="0.3", linewidths=1.0, linestyles="-")
    draws = 1e-3 * one["example_draws"].transpose("draw", "axis").values
    axes.plot(*draws.T, ".", markersize=1.5, color=PASSIVE_COLOURS["Student-t ML"], alpha=0.6)
    root = np.linalg.cholesky(one["example_covariance"].transpose("axis", "axis2").values)
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    ellipse = one["example_mode"].values[:, None] + np.sqrt(4.605) * root @ circle
    axes.plot(*(1e-3 * ellipse), "--", color=PASSIVE_COLOURS["RRTLS"], label="Laplace, 90 %")
    axes.plot([], [], color="0.3", label="exact, 50 and 90 %")
    axes.plot(*(1e-3 * one["example_truth"].values), "k+", markersize=9, label="truth")
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0], y[-1])
    axes.set_xlabel("x (km)")
    axes.set_ylabel("y (km)")
    axes.set_title("six bearings, Student-t")
    axes.legend(fontsize=6.5)
