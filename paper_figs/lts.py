"""LTS paper, Figures 3 and 4: error against noise level and against threshold, three scores."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from paper_figs._lts import BREAKDOWN, READINGS, load, source, suffix
from paper_figs._style import BOUND, LTS_COLOURS, WIDTH, footnote, save, shared_legend
from probreg.typing import BoolArray, FloatArray

# parameter: panel title, factor from SI, unit
SHOWN = {
    "A.range": ("range bias of A", 1.0, "m"),
    "A.azimuth": ("azimuth bias of A", 180.0 / np.pi, "deg"),
    "B.range": ("range bias of B", 1.0, "m"),
    "B.azimuth": ("azimuth bias of B", 180.0 / np.pi, "deg"),
}
# few wrong pairs: at most BREAKDOWN of them
SCORES = {
    "pooled": "RMSE, all runs",
    "median": "median absolute error",
    "quarter": "RMSE, few wrong pairs",
}
# fills the panels from (data, manifest) and gives what the footnote says of them
Fill = Callable[[np.ndarray, xr.Dataset, dict[str, Any]], str]
Scores = dict[tuple[str, str, str], list[float]]


def draw_scores(
    profile: str, results: Path, out: Path, *, number: int, height: float, fill: Fill
) -> list[Path]:
    """Draw one figure a reading: one row of panels a score, one column a parameter."""
    paths = []
    for reading in READINGS:
        data, manifest = load("lts", reading, profile, results)
        figure, grid = plt.subplots(3, 4, figsize=(WIDTH, height), sharex=True)
        text = fill(grid, data, manifest)
        for axes, (title, _, unit) in zip(grid[0], SHOWN.values(), strict=True):
            axes.set_title(f"{title} ({unit})", fontsize=8)
        for axes, label in zip(grid[:, 0], SCORES.values(), strict=True):
            axes.set_ylabel(label)
        footnote(figure, source(manifest, text))
        paths += save(figure, f"lts_fig{number}{suffix(reading)}", out)
    return paths


def _by_noise(grid: np.ndarray, data: xr.Dataset, manifest: dict[str, Any]) -> str:
    """Figure 3: every method, and the bound."""
    scores = _tabulate(data)
    sigma = data["sigma"].values
    wrong = data["wrong_share"].transpose("case", "sigma").values
    for row, name in zip(grid, SCORES, strict=True):
        for axes, (parameter, (_, factor, unit)) in zip(row, SHOWN.items(), strict=True):
            for method in (str(m) for m in data["estimator"].values):
                values = factor * np.array(scores[name, method, parameter])
                axes.plot(sigma, values, marker=".", color=LTS_COLOURS[method], label=method)
            sd = data["bound_sd"].sel(parameter=parameter).transpose("case", "sigma").values
            line = [_bound_score(name, sd[:, s], wrong[:, s]) for s in range(len(sigma))]
            axes.plot(sigma, factor * np.array(line), label="bound, right pairs", **BOUND)
            axes.set_yscale("symlog", linthresh=30.0 if unit == "m" else 0.03)
            axes.set_ylim(bottom=0.0)
    for axes in grid[-1]:
        axes.set_xlabel("sigma (m)")
    shared_legend(grid[0, 0].figure, grid[0, 0], 6)
    return _claim(data, scores)


def _by_threshold(grid: np.ndarray, data: xr.Dataset, manifest: dict[str, Any]) -> str:
    """Figure 4: RLS at one noise level."""
    errors = (data["sweep_theta"] - data["truth"]).transpose("parameter", "threshold", "case")
    wrong = data["sweep_wrong_share"].values
    thresholds = data["threshold"].values
    # the bound is linear in sigma, run by run: one noise level gives it at any other
    last = data["bound_sd"].isel(sigma=-1)
    sds = last * (manifest["config"]["sweep_sigma_m"] / float(last["sigma"]))
    best = []
    for row, name in zip(grid, SCORES, strict=True):
        curves = []
        for axes, (parameter, (_, factor, _)) in zip(row, SHOWN.items(), strict=True):
            each = errors.sel(parameter=parameter).values
            values = factor * np.array([_score(name, e, wrong) for e in each])
            curves.append(values / values.min())
            axes.plot(thresholds, values, marker=".", color=LTS_COLOURS["RLS"])
            sd = sds.sel(parameter=parameter).values
            axes.axhline(factor * _bound_score(name, sd, wrong), **BOUND)
            lowest = int(np.argmin(values))
            axes.plot(thresholds[lowest], values[lowest], "o", color="0.15", fillstyle="none")
        best.append(f"{thresholds[np.argmin(np.mean(curves, axis=0))]:.0f} ({SCORES[name]})")
    for axes in grid[-1]:
        axes.set_xlabel(r"threshold $\rho'$")
    return (
        "sigma = 100 m; circle: least error; dotted: bound, right pairs\n"
        f"Best over all parameters: {', '.join(best)}"
    )


def _score(name: str, errors: FloatArray, wrong: FloatArray) -> float:
    """One of SCORES of errors (cases,) given each case's share of wrong pairs."""
    if name == "median":
        return float(np.median(np.abs(errors)))
    keep: BoolArray = wrong <= BREAKDOWN if name == "quarter" else np.ones(len(wrong), dtype=bool)
    return float(np.sqrt(np.mean(errors[keep] ** 2))) if keep.any() else float("nan")


def _bound_score(name: str, sd: FloatArray, wrong: FloatArray) -> float:
    """The same score of an estimator that attains the bound in every case."""
    if name == "median":
        return float(0.6745 * np.median(sd))
    return _score(name, sd, wrong)


def _tabulate(data: xr.Dataset) -> Scores:
    """Every score of every method and parameter, by noise level."""
    errors: FloatArray = (
        (data["theta"] - data["truth"]).transpose("estimator", "parameter", "sigma", "case").values
    )
    wrong = data["wrong_share"].transpose("sigma", "case").values
    return {
        (name, str(method), str(parameter)): [
            _score(name, errors[m, p, s], wrong[s]) for s in range(len(wrong))
        ]
        for name in SCORES
        for m, method in enumerate(data["estimator"].values)
        for p, parameter in enumerate(data["parameter"].values)
    }


def _claim(data: xr.Dataset, scores: Scores) -> str:
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


FIGURES = {
    "lts_fig3": partial(draw_scores, number=3, height=6.6, fill=_by_noise),
    "lts_fig4": partial(draw_scores, number=4, height=6.2, fill=_by_threshold),
}
