"""The posterior of six biases on one RALAD data set, beside RLS and RALAD and what they claim."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from experiments.results import load_result
from paper_figs.bayes_common import LAW_COLOURS
from paper_figs.ralad_common import SHOWN, SOURCE
from paper_figs.style import COLOURS, TRUTH, WIDTH, footnote, save
from paper_figs.tables import save_table

Z90 = 1.6449


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw intervals of every law and method by bias, and a table of the laws compared."""
    data, manifest = load_result("posterior_ralad", profile, results)
    one = data.isel(replicate=0)
    laws = [str(s) for s in one["law"].values]
    points = [str(s) for s in one["estimator"].values]
    figure, grid = plt.subplots(2, 3, figsize=(WIDTH, 4.4), sharey=True)
    for axes, parameter in zip(
        grid.ravel(), (str(p) for p in one["parameter"].values), strict=True
    ):
        label, factor, unit = SHOWN[parameter.split(".")[1]]
        rows = [*points, *laws]
        for y, name in enumerate(rows):
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
        axes.set_yticks(range(len(rows)), [*points, *(f"posterior, {law}" for law in laws)],
                        fontsize=7)  # fmt: skip
    grid[0, 0].invert_yaxis()
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
    table = []
    for law in laws:
        chosen = one.sel(law=law)
        table.append(
            [
                law,
                f"{float(chosen['elpd']):.1f}",
                f"{float(chosen['behind']):.1f} ± {float(chosen['behind_error']):.1f}",
                f"{float(chosen['pareto_k']):.2f}",
                f"{float(chosen['seconds']):.2f}",
            ]
        )
    config = manifest["config"]
    note = f"Leave-one-out on {min(config['compared_rows'], len(clean))} rows of {len(clean)}"
    header = ["law", "elpd", "behind the best", "Pareto k", "seconds"]
    title = "Which law? Leave-one-out on one RALAD data set"
    return paths + save_table("posterior_ralad_table", title, header, table, note, out)
