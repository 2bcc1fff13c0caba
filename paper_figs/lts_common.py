"""What the figures of the LTS paper share: loading, the three scores, panels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from experiments.results import load_result
from probreg.typing import BoolArray, FloatArray

SOURCE = "Tian and Huang, J. Electronics & Information Technology 40(3), 2018"
READINGS = ("literal", "symmetric")
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
BREAKDOWN = 0.25  # share of wrong pairs that LTS with 75 % coverage still bears


def load(
    study: str, reading: str, profile: str, results: Path
) -> tuple[xr.Dataset, dict[str, Any]]:
    """Results of one reading with blocks and runs joined to one dimension "case"."""
    data, manifest = load_result(study, f"{profile},reading={reading}", results)
    return data.stack(case=("replicate", "run"), create_index=False), manifest


def score(name: str, errors: FloatArray, wrong: FloatArray) -> float:
    """One of SCORES of errors (cases,) given each case's share of wrong pairs."""
    if name == "median":
        return float(np.median(np.abs(errors)))
    keep: BoolArray = wrong <= BREAKDOWN if name == "quarter" else np.ones(len(wrong), dtype=bool)
    return float(np.sqrt(np.mean(errors[keep] ** 2))) if keep.any() else float("nan")


def bound_score(name: str, sd: FloatArray, wrong: FloatArray) -> float:
    """The same score of an estimator that attains the bound in every case."""
    if name == "median":
        return float(0.6745 * np.median(sd))
    return score(name, sd, wrong)


def label_panels(grid: np.ndarray, xlabel: str) -> None:
    """Name the panels of a grid: one row a score, one column a parameter."""
    for axes, (title, _, unit) in zip(grid[0], SHOWN.values(), strict=True):
        axes.set_title(f"{title} ({unit})", fontsize=8)
    for axes, text in zip(grid[:, 0], SCORES.values(), strict=True):
        axes.set_ylabel(text)
    for axes in grid[-1]:
        axes.set_xlabel(xlabel)


def suffix(reading: str) -> str:
    """Ending of the file name: the literal reading has none."""
    return "" if reading == "literal" else f"_{reading}"


def source(manifest: dict[str, Any], text: str) -> str:
    """Footnote: where the numbers come from."""
    config = manifest["config"]
    runs = config["replicates"] * config["runs"]
    place = "(0, 80)" if config["reading"] == "literal" else "(50, 80)"
    where = f"{config['reading']} reading: square centred at {place} km; {runs} runs"
    return f"{SOURCE}\n{where}; few wrong pairs: at most {BREAKDOWN:.0%}\n{text}"
