"""The posterior of six biases on one RALAD data set, beside RLS and RALAD and what they claim."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from experiments.results import load_result
from paper_figs._bayes import LAW_COLOURS
from paper_figs._ralad import SHOWN, SOURCE
from paper_figs._style import COLOURS, TRUTH, WIDTH, footnote, name_rows, save
from paper_figs._tables import save_table

Z90 = 1.6449


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw intervals of every law and method by bias, and a table of the laws compared."""
    data, manifest = load_result("posterior_ralad", profile, results)
    one = data.isel(replicate=0)
    figure, grid = plt.subplots(2, 3, figsize=(WIDTH, 4.4), sharey=True)
    parameters = [str(p) for p in one["parameter"].values]
    for axes, parameter in zip(grid.ravel(), parameters, strict=True):
        _intervals(axes, one, parameter)
    clean = one["clean"].values.astype(bool)
    probability = one["outlier_probability"].values
    text = (
        f"Data after {SOURCE}, case 1, {len(clean)} rows, one data set; 90 % intervals; dashed: "
        "truth\nThe noise parameters of Laplace, Student-t and contaminated are unknown too\nMean "
        f"outlier probability: {probability[clean].mean():.3f} of clean rows, "
        f"{probability[~clean].mean():.3f} of spoiled ones"
    )
    footnote(figure, text)
    paths = save(figure, "posterior_ralad", out)
    compared = min(manifest["config"]["compared_rows"], len(clean))
    note = f"Leave-one-out on {compared} rows of {len(clean)}"
    header = ["law", "elpd", "behind the best", "Pareto k", "seconds"]
    title = "Which law? Leave-one-out on one RALAD data set"
    return paths + save_table("posterior_ralad_table", title, header, _compared(one), note, out)


def _intervals(axes: Axes, one: xr.Dataset, parameter: str) -> None:
    """One bias: what the methods claim, then the posterior under each law."""
    label, factor, unit = SHOWN[parameter.split(".")[1]]
    laws = [str(s) for s in one["law"].values]
    points = [str(s) for s in one["estimator"].values]
    for y, name in enumerate([*points, *laws]):
        if name in points:
            chosen = one.sel(estimator=name, parameter=parameter)
            centre, sd = factor * float(chosen["point"]), factor * float(chosen["point_sd"])
            ends, colour, marker = (centre - Z90 * sd, centre + Z90 * sd), COLOURS[name], "s"
        else:
            draws = factor * one["theta"].sel(law=name, parameter=parameter).values
            centre, ends = float(draws.mean()), tuple(np.quantile(draws, [0.05, 0.95]))
            colour, marker = LAW_COLOURS[name], "o"
        axes.plot(ends, [y, y], color=colour, linewidth=2.0)
        axes.plot(centre, y, marker, color=colour, markersize=4)
    axes.axvline(factor * float(one["truth"].sel(parameter=parameter)), **TRUTH)
    axes.set_title(f"{parameter.split('.')[0]}: {label} ({unit})")
    name_rows(axes, [*points, *(f"posterior, {law}" for law in laws)])


def _compared(one: xr.Dataset) -> list[list[str]]:
    """Rows of the table, a law each."""
    rows = []
    for law in (str(s) for s in one["law"].values):
        chosen = one.sel(law=law)
        rows.append(
            [
                law,
                f"{float(chosen['elpd']):.1f}",
                f"{float(chosen['behind']):.1f} ± {float(chosen['behind_error']):.1f}",
                f"{float(chosen['pareto_k']):.2f}",
                f"{float(chosen['seconds']):.2f}",
            ]
        )
    return rows
