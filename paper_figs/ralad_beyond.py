"""Beyond the RALAD paper: RMSE of every method and reading against the Cramer-Rao bound."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from paper_figs._ralad import PARAMETERS, load_case, unit_factor
from paper_figs._style import BOUND, COLOURS, WIDTH, footnote, name_rows, save, shared_legend
from paper_figs._tables import save_table
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
        paths += _tables(case, loaded, runs, out)
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
        name_rows(row[0], methods)
    for reading, marker in MARKERS.items():
        grid[0, 0].plot([], [], marker, color="0.3", markersize=4, label=reading)
    grid[0, 0].plot([], [], label="Cramer-Rao bound, all rows clean", **BOUND)
    shared_legend(figure, grid[0, 0], 5)
    text = (
        f"{runs} runs a case, both sensors pooled, bars: 95 %; symbols: where B and R are "
        "evaluated (relinearised: unbiased conversion, fused position)"
    )
    footnote(figure, text)
    return save(figure, "ralad_beyond", out)


def _tables(case: int, data: xr.Dataset, runs: int, out: Path) -> list[Path]:
    note = (
        f"{runs} runs, ± standard error; m and mrad. The bound is for all rows clean; here "
        f"{float(data['clean_share'].mean()):.0%} are.\nFits that did not converge: "
        f"{int(data['not_converged'].sum())}."
    )
    bound = data["bound_sd"].mean("replicate")
    bounds = [unit_factor(p) * float(bound.sel(parameter=p)) for p in PARAMETERS]
    last = ["Cramer-Rao bound", *(_number(b, p) for b, p in zip(bounds, PARAMETERS, strict=True))]
    paths = []
    for which, name in enumerate(("bias", "RMSE")):
        header = [name, *(f"{p[2:]} {p[0]}" for p in PARAMETERS)]
        rows: list[list[str]] = []
        for reading in data["reading"].values:
            rows.append([f"B, R: {reading}"])
            for method in data["estimator"].values:
                found = [_measure(data, str(method), str(reading), p)[which] for p in PARAMETERS]
                if np.isfinite(found[0].value):
                    rows.append([f"  {method}", *map(_cell, found, PARAMETERS)])
        title = f"Beyond the paper, {TITLES[case]}: {name}"
        label = f"ralad_beyond_case{case}_{name.lower()}"
        paths += save_table(label, title, header, [*rows, *([last] if which else [])], note, out)
    return paths


def _number(value: float, parameter: str) -> str:
    return f"{value:.{2 if parameter.endswith('range') else 3}f}"


def _cell(measured: Measured, parameter: str) -> str:
    value, error = float(measured.value), float(measured.standard_error)
    return f"{_number(value, parameter)} ± {_number(error, parameter)}"
