"""Beyond the RALAD paper: RMSE of every method and reading against the Cramer-Rao bound."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from paper_figs.ralad_common import PARAMETERS, load_case, unit_factor
from paper_figs.style import BOUND, COLOURS, WIDTH, footnote, save
from paper_figs.tables import save_table
from probreg.diagnostics import Measured, bias, rmse

TITLES = {0: "clean data", 1: "case 1", 2: "case 2"}
GROUPS = {"range": "range (m)", "azimuth": "azimuth (mrad)", "elevation": "elevation (mrad)"}
MARKERS = {"true": "o", "smooth": "s", "measured": "^", "relinearised": "D"}


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw the figure and write the tables, one a case."""
    cases = {case: load_case("ralad_beyond", case, profile, results) for case in TITLES}
    runs = next(iter(cases.values()))[1]["replicates"]
    data = {case: loaded for case, (loaded, _) in cases.items()}
    paths = _figure(data, runs, out)
    for case, loaded in data.items():
        paths += _table(case, loaded, runs, out)
    return paths


def _measure(
    data: xr.Dataset, method: str, reading: str, parameter: str
) -> tuple[Measured, Measured]:
    """Bias and RMSE in the unit shown; NaN where the method was not run on that reading."""
    theta = data["theta"].sel(estimator=method, reading=reading, parameter=parameter).values
    truth, factor = float(data["truth"].sel(parameter=parameter)), unit_factor(parameter)
    if np.isnan(theta).all():
        blank = Measured(np.array(np.nan), np.array(np.nan))
        return blank, blank
    return bias(factor * theta, factor * truth), rmse(factor * theta, factor * truth)


def _pooled(data: xr.Dataset, method: str, reading: str, quantity: str) -> tuple[float, float]:
    """RMSE over both sensors, and its standard error."""
    squares, errors = [], []
    for parameter in (p for p in PARAMETERS if p.endswith(quantity)):
        _, measured = _measure(data, method, reading, parameter)
        squares.append(float(measured.value) ** 2)
        errors.append(2.0 * float(measured.value) * float(measured.standard_error))
    value = float(np.sqrt(np.mean(squares)))
    # both sensors see the same runs, so their errors are added, not their squares
    return value, float(np.mean(errors)) / max(2.0 * value, 1e-300)


def _bound(data: xr.Dataset, quantity: str) -> float:
    sds = data["bound_sd"].mean("replicate")
    values = [
        unit_factor(p) * float(sds.sel(parameter=p)) for p in PARAMETERS if p.endswith(quantity)
    ]
    return float(np.sqrt(np.mean(np.square(values))))


def _figure(cases: dict[int, xr.Dataset], runs: int, out: Path) -> list[Path]:
    methods = [str(m) for m in next(iter(cases.values()))["estimator"].values]
    figure, grid = plt.subplots(len(cases), 3, figsize=(WIDTH, 7.4), sharey=True, sharex="col")
    for row, (case, data) in zip(grid, cases.items(), strict=True):
        for axes, (quantity, label) in zip(row, GROUPS.items(), strict=True):
            for y, method in enumerate(methods):
                for k, (reading, marker) in enumerate(MARKERS.items()):
                    value, error = _pooled(data, method, reading, quantity)
                    axes.errorbar(value, y + 0.18 * (k - 1.5), xerr=1.96 * error, fmt=marker,
                                  color=COLOURS[method], markersize=3.2, linewidth=0.8)  # fmt: skip
            axes.axvline(_bound(data, quantity), **BOUND)
            axes.set_xscale("log")
            axes.set_title(f"{TITLES[case]}: {quantity}")
            if case == max(cases):
                axes.set_xlabel(f"RMSE, {label}")
        row[0].set_yticks(range(len(methods)), methods, fontsize=7)
        row[0].invert_yaxis()
    handles = [
        plt.Line2D([], [], color="0.3", marker=marker, linestyle="", markersize=4, label=reading)
        for reading, marker in MARKERS.items()
    ]
    handles.append(plt.Line2D([], [], label="Cramer-Rao bound, all rows clean", **BOUND))
    figure.legend(handles=handles, loc="outside upper center", ncols=5)
    text = (
        f"{runs} runs a case, both sensors pooled, bars: 95 %; symbols: where B and R are "
        "evaluated (relinearised: unbiased conversion, fused position)"
    )
    footnote(figure, text)
    return save(figure, "ralad_beyond", out)


def _table(case: int, data: xr.Dataset, runs: int, out: Path) -> list[Path]:
    header = ["RMSE (bias)", "range i", "azimuth i", "elevation i",
              "range j", "azimuth j", "elevation j"]  # fmt: skip
    rows: list[list[str]] = []
    for reading in data["reading"].values:
        rows.append([f"B, R: {reading}"])
        for method in data["estimator"].values:
            cells = []
            for parameter in PARAMETERS:
                drift, error = _measure(data, str(method), str(reading), parameter)
                cells.append(f"{error.value:.3g}±{error.standard_error:.1g} ({drift.value:+.2g})")
            if "nan" not in cells[0]:
                rows.append([f"  {method}", *cells])
    bound = data["bound_sd"].mean("replicate")
    rows.append(["Cramer-Rao bound", *(f"{unit_factor(p) * float(bound.sel(parameter=p)):.3g}"
                                       for p in PARAMETERS)])  # fmt: skip
    note = (
        f"{runs} runs; m and mrad; RMSE ± its standard error, mean error in brackets. The bound is "
        f"for all rows clean; here {float(data['clean_share'].mean()):.0%} are."
    )
    title = f"Beyond the paper, {TITLES[case]}"
    return save_table(f"ralad_beyond_case{case}", title, header, rows, note, out)
