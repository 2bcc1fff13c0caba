"""A moving bias on a recording of asynchronous radars: every method, four kinds of truth."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter

from experiments.results import load_result
from paper_figs._errors import ONLINE, WHOLE, error_bars, mean_and_error, rmse
from paper_figs._style import TRUTH, WIDTH, footnote, name_rows, save
from paper_figs._tables import save_table
from probreg.typing import FloatArray

TITLES = {"walk": "walk", "step": "step", "ramp": "ramp", "none": "nothing moves"}
SHOWN = ("watch, spread unknown", "drift, spread unknown", "MH", "MH, gamma 10")
UNIT = 1e3  # thousandths of a degree


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw errors and coverage, the bands of one recording, and write the table."""
    every = {kind: _load(profile, kind, results) for kind in TITLES}
    return [*_errors(every, out), *_bands(every, out), *_table(every, out)]


def _load(profile: str, kind: str, results: Path) -> xr.Dataset:
    data, manifest = load_result("recording_drift", f"{profile},truth={kind}", results)
    return data.rename(replicate="case").assign_attrs(config=manifest["config"])


def _off(data: xr.Dataset) -> xr.DataArray:
    return data["bias"].sel(bound="mean") - data["truth"]


def _held(data: xr.Dataset) -> xr.DataArray:
    low, high = (data["bias"].sel(bound=bound) for bound in ("low", "high"))
    return ((low <= data["truth"]) & (data["truth"] <= high)).astype(float)


def _delay(data: xr.Dataset, method: str) -> FloatArray:
    """Seconds (cases,) after a step until the estimate is nearer to the new bias than the old."""
    config = data.attrs["config"]
    after = data["time"].values - 30.0 * config["minutes"]
    seen = after > 0.0
    near = np.abs(_off(data).sel(estimator=method).values[:, seen]) < 0.5 * config["step_deg"]
    first = np.where(near.any(axis=1), near.argmax(axis=1), -1)
    return np.where(first >= 0, after[seen][first], np.inf)


def _errors(every: dict[str, xr.Dataset], out: Path) -> list[Path]:
    figure, grid = plt.subplots(2, 4, figsize=(WIDTH, 5.4), sharey=True)
    for k, (kind, data) in enumerate(every.items()):
        methods = [str(name) for name in data["estimator"].values]
        past = data["past_only"].isel(case=0).values
        colours = [ONLINE if own else WHOLE for own in past]
        at = np.arange(len(methods))
        off, held = _off(data), _held(data)
        errors = np.array([rmse((UNIT * off.sel(estimator=m)) ** 2) for m in methods])
        shares = np.array([mean_and_error(held.sel(estimator=m)) for m in methods])
        error_bars(grid[0, k], at, errors, colours)
        error_bars(grid[1, k], at, shares, colours)
        for axes in grid[:, k]:
            name_rows(axes, methods)
        grid[0, k].set_xscale("log")
        grid[0, k].xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        grid[0, k].xaxis.set_major_formatter(ScalarFormatter())
        grid[0, k].xaxis.set_minor_locator(NullLocator())
        grid[0, k].set_title(TITLES[kind])
        grid[0, k].set_xlabel("RMSE (0.001 deg)")
        grid[1, k].axvline(0.9, color="0.15", linewidth=1.0, linestyle=":")
        grid[1, k].set_xlabel("90 % holds")
    footnote(figure, _note(every))
    return save(figure, "recording_drift", out)


def _bands(every: dict[str, xr.Dataset], out: Path) -> list[Path]:
    figure, grid = plt.subplots(
        len(SHOWN), len(every), figsize=(WIDTH, 6.0), sharex=True, sharey="col"
    )
    for k, (kind, data) in enumerate(every.items()):
        one = data.isel(case=0)
        minutes = one["time"].values / 60.0
        for axes, method in zip(grid[:, k], SHOWN, strict=True):
            band = one["bias"].sel(estimator=method)
            low, high = (band.sel(bound=b).values for b in ("low", "high"))
            axes.fill_between(minutes, low, high, color="C0", alpha=0.25, linewidth=0)
            axes.plot(minutes, band.sel(bound="mean").values, color="C0", linewidth=0.9)
            axes.plot(minutes, one["truth"].values, **TRUTH)
            if k == 0:
                axes.set_ylabel(method, fontsize=7)
        grid[0, k].set_title(TITLES[kind])
        grid[-1, k].set_xlabel("time (min)")
    text = "Bias in degrees, one recording each. Line and band: mean and 90 %; dashed: truth."
    footnote(figure, text)
    return save(figure, "recording_drift_bands", out)


def _table(every: dict[str, xr.Dataset], out: Path) -> list[Path]:
    rows: list[list[str]] = []
    for kind, data in every.items():
        rows.append([TITLES[kind]])
        off, held, seconds = _off(data), _held(data), data["seconds"].median("case")
        for method in (str(name) for name in data["estimator"].values):
            value, error = rmse((UNIT * off.sel(estimator=method)) ** 2)
            share, own = mean_and_error(held.sel(estimator=method))
            cells = [f"{value:.1f} ± {error:.1f}", f"{share:.3f} ± {own:.3f}"]
            late = f"{np.median(_delay(data, method)):.0f}" if kind == "step" else ""
            rows.append(
                [f"  {method}", *cells, late, f"{float(seconds.sel(estimator=method)):.2f}"]
            )
    header = ["", "RMSE (0.001 deg)", "90 % holds", "delay (s)", "seconds"]
    title = "A moving azimuth bias, by what radars saw of the same aircraft"
    note = (
        _note(every)
        + "\nDelay: median time after the step until the estimate is nearer to the new "
        "bias. Seconds of one recording; methods on slices include the watch that makes these."
    )
    return save_table("recording_drift_table", title, header, rows, note, out)


def _note(every: dict[str, xr.Dataset]) -> str:
    data = every["walk"]
    config = data.attrs["config"]
    return (
        f"{data.sizes['case']} recordings of {config['minutes']:g} min, {config['aircraft']} "
        f"aircraft, {config['wrong_share']:.0%} wrong pairs, {config['outlier_share']:.0%} "
        "outliers.\nBlue: from what was seen so far, red: from all. Methods on slices assume a "
        f"walk of {config['walk_deg']:g} degrees a root minute."
    )
