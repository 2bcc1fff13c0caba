"""Robust total-least-squares paper, Table 1: outliers as used; and errors of every method."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from paper_figs._cases import load_cases, runs_of
from paper_figs._passive import PERCENT, TOTAL_SOURCE, root_bound
from paper_figs._tables import save_table
from probreg.diagnostics import rmse

POINTS = (50, 100, 150, 200)
TITLES = {"none": "no outliers", "table": "outliers of Table 1"}


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Write both tables."""
    data, manifest = load_cases("rrtls", profile, results)
    size = data["size"].isel(case=0).values
    at = np.flatnonzero(size)
    groups = np.split(at, np.flatnonzero((np.diff(at) > 1) & (np.diff(size[at]) != 0.0)) + 1)
    rows = []
    for group in groups:
        points = data["point"].values[group]
        run = len(group) > 1 and bool(np.all(np.diff(points) == 1))
        text = f"{points[0]}-{points[-1]}" if run else ", ".join(map(str, points))
        rows.append([text, f"{size[group[0]]:.0f} sigma"])
    note = (
        f"{TOTAL_SOURCE}\nThe paper's table is lost; these make its own figures come out. They "
        "are added to the noise."
    )
    title = "Table 1: outliers as used"
    paths = save_table("rrtls_table1", title, ["point", "size"], rows, note, out)
    bound = PERCENT * root_bound(data, "point")
    cells: list[list[str]] = [["Cramér-Rao bound", *(f"{bound[p - 1]:.3g}" for p in POINTS)]]
    for condition, heading in TITLES.items():
        cells.append([heading])
        for name in data["estimator"].values:
            square = data["squared_error"].sel(outliers=condition, estimator=name)
            found = [rmse(PERCENT * np.sqrt(square.sel(point=p).values), 0.0) for p in POINTS]
            shown = [f"{float(f.value):.3g} ± {float(f.standard_error):.1g}" if np.isfinite(f.value)
                     else "-" for f in found]  # fmt: skip
            cells.append([f"  {name}", *shown])
    header = ["root mean square error (%)", *(f"n = {p}" for p in POINTS)]
    title = "Relative distance errors, +- standard error"
    note = f"{TOTAL_SOURCE}; {runs_of(manifest)} runs; percent of 180 km"
    return paths + save_table("rrtls_errors", title, header, cells, note, out)
