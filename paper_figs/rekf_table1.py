"""Robust EKF paper, Table 1: outliers as used; errors of every method; cost of a pass."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from paper_figs._cases import load_cases, runs_of
from paper_figs._passive import FILTER_SOURCE, READING_TITLES, SIGMAS, root_bound
from paper_figs._tables import save_table
from probreg.diagnostics import rmse

TIMES = (20, 99, 160, 200)


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Write the three tables."""
    loaded = {s: load_cases("rekf", f"{profile},sigma_deg={s}", results) for s in SIGMAS}
    data, manifest = loaded[SIGMAS[0]]
    note = f"{FILTER_SOURCE}; {runs_of(manifest)} runs"
    paths = _outliers(data, out)
    rows: list[list[str]] = []
    for sigma, (found, _) in loaded.items():
        bound = root_bound(found, "time")
        rows.append([f"sigma = {sigma} deg"])
        rows.append(["  Cramér-Rao bound", *(f"{bound[t]:.4g}" for t in TIMES)])
        for reading, title in READING_TITLES.items():
            rows.append([f"{title}, sigma = {sigma} deg"])
            for name in found["estimator"].values:
                rows.append([f"  {name}", *_errors(found, reading, str(name))])
    header = ["RMSE of position (m)", *(f"{t} s" for t in TIMES)]
    title = "Errors of the robust EKF paper's methods, +- standard error"
    paths += save_table("rekf_errors", title, header, rows, note, out)
    return paths + _cost(loaded, note, out)


def _outliers(data: xr.Dataset, out: Path) -> list[Path]:
    size = data["size"].isel(case=0).values
    at = np.flatnonzero(size)
    breaks = np.flatnonzero((np.diff(at) > 1) | (np.diff(size[at]) != 0.0)) + 1
    rows = []
    for group in np.split(at, breaks):
        first, last = data["time"].values[group[[0, -1]]]
        span = f"{first:.0f}" if first == last else f"{first:.0f}-{last:.0f}"
        rows.append([span, f"{size[group[0]]:.0f} sigma"])
    note = (
        f"After Table 1 of {FILTER_SOURCE}\n"
        "Read as noise of that standard deviation, and as that error to one side."
    )
    title = "Table 1: outliers as used"
    return save_table("rekf_table1", title, ["time (s)", "size"], rows, note, out)


def _errors(data: xr.Dataset, reading: str, name: str) -> list[str]:
    square = data["squared_error"].sel(outliers=reading, estimator=name)
    cells = []
    for t in TIMES:
        values = square.sel(time=float(t)).values
        found = rmse(np.sqrt(values), 0.0)
        cells.append(f"{float(found.value):.4g} ± {float(found.standard_error):.2g}")
    return cells


def _cost(
    loaded: dict[float, tuple[xr.Dataset, dict[str, object]]], note: str, out: Path
) -> list[Path]:
    rows = []
    for sigma, (data, _) in loaded.items():
        for reading, title in READING_TITLES.items():
            rows.append([f"{title}, sigma = {sigma} deg"])
            seconds = {
                str(name): float(data["seconds_pass"].sel(outliers=reading, timed=name).median())
                for name in data["timed"].values
            }
            for name, value in seconds.items():
                chosen = data.sel(outliers=reading, estimator=name)
                passes = "0" if name == "EKF" else f"{float(chosen['passes'].mean()):.3g}"
                rejected = f"{float(chosen['rejected'].mean()):.2f}"
                ratio = f"{value / seconds['REKF']:.2f}"
                rows.append([f"  {name}", passes, rejected, f"{1e6 * value:.0f}", ratio])
    header = [
        "",
        "repeated updates a bearing",
        "bearings rejected",
        "time of 200 bearings (us)",
        "over REKF",
    ]
    title = "What the gate saves: inner iterations and time"
    text = f"{note}\nTimes of the compiled filter alone, median over replicates, this machine"
    return save_table("rekf_cost", title, header, rows, text, out)
