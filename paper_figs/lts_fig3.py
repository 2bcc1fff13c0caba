"""LTS paper, Figure 3: error against the noise level, both readings, three scores."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from paper_figs.lts_common import (
    BREAKDOWN,
    READINGS,
    SCORES,
    SHOWN,
    bound_score,
    label_panels,
    load,
    score,
    source,
    suffix,
)
from paper_figs.style import BOUND, LTS_COLOURS, WIDTH, footnote, save
from probreg.typing import FloatArray


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one figure a reading."""
    paths = []
    for reading in READINGS:
        data, manifest = load("lts", reading, profile, results)
        scores = tabulate(data)
        figure, grid = plt.subplots(3, 4, figsize=(WIDTH, 6.6), sharex=True)
        sigma = data["sigma"].values
        wrong = data["wrong_share"].transpose("case", "sigma").values
        for row, name in zip(grid, SCORES, strict=True):
            for axes, parameter in zip(row, SHOWN, strict=True):
                _, factor, unit = SHOWN[parameter]
                for method in data["estimator"].values:
                    values = factor * np.array(scores[name, str(method), parameter])
                    colour = LTS_COLOURS[str(method)]
                    axes.plot(sigma, values, marker=".", color=colour, label=method)
                sd = data["bound_sd"].sel(parameter=parameter).transpose("case", "sigma").values
                line = [bound_score(name, sd[:, s], wrong[:, s]) for s in range(len(sigma))]
                axes.plot(sigma, factor * np.array(line), label="bound, right pairs", **BOUND)
                axes.set_yscale("symlog", linthresh=30.0 if unit == "m" else 0.03)
                axes.set_ylim(bottom=0.0)
        label_panels(grid, "sigma (m)")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=6)
        footnote(figure, source(manifest, claim(data, scores)))
        paths += save(figure, f"lts_fig3{suffix(reading)}", out)
    return paths


Scores = dict[tuple[str, str, str], list[float]]


def tabulate(data: xr.Dataset) -> Scores:
    """Every score of every method and parameter, by noise level."""
    errors: FloatArray = (
        (data["theta"] - data["truth"]).transpose("estimator", "parameter", "sigma", "case").values
    )
    wrong = data["wrong_share"].transpose("sigma", "case").values
    return {
        (name, str(method), str(parameter)): [
            score(name, errors[m, p, s], wrong[s]) for s in range(len(wrong))
        ]
        for name in SCORES
        for m, method in enumerate(data["estimator"].values)
        for p, parameter in enumerate(data["parameter"].values)
    }


def claim(data: xr.Dataset, scores: Scores) -> str:
    """Say where the paper's order RLS < LTS < LMS < LS holds, from the numbers drawn."""
    said = []
    for name, text in SCORES.items():
        rows = np.array(
            [
                [scores[name, method, parameter] for method in ("RLS", "LTS", "LMS", "LS")]
                for parameter in SHOWN
            ]
        )
        holds = (np.diff(rows, axis=1) > 0.0).all(axis=1)
        said.append(f"{holds.sum()} of {holds.size} ({text})")
    level = float(data["sigma"][len(data["sigma"]) // 2])
    share = float((data["wrong_share"].sel(sigma=level) > BREAKDOWN).mean())
    return (
        f"Order RLS < LTS < LMS < LS holds in {'; '.join(said)}\n"
        f"More than 25 % wrong pairs in {share:.0%} of the runs at sigma = {level:.0f} m"
    )
