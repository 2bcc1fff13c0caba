"""RALAD paper, Figures 1-8: estimates against the scan, and condition numbers."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from paper_figs._ralad import SHOWN, SOURCE, load_case, mean_estimate
from paper_figs._style import COLOURS, TRUTH, WIDTH, footnote, save, shared_legend
from probreg.diagnostics import Measured, bias


def draw_estimates(
    profile: str, results: Path, out: Path, *, number: int, case: int, quantity: str
) -> list[Path]:
    """Figures 1-6: mean estimate of one bias of both sensors against the scan."""
    data, manifest = load_case("ralad", case, profile, results)
    label, _, unit = SHOWN[quantity]
    figure, grid = plt.subplots(2, 2, figsize=(WIDTH, 4.6), sharex=True)
    for column, sensor in zip(grid.T, "ij", strict=True):
        _estimates(column, data, sensor, quantity)
        column[0].set_title(f"sensor {sensor}")
        column[1].set_title("without RLS")
        column[1].set_xlabel("scan (0.1 s)")
        for axes in column:
            axes.set_ylabel(f"{label} bias ({unit})")
    shared_legend(figure, grid[0, 0], 5)
    footnote(
        figure, _source(manifest, "mean estimate, band: 95 % of the mean; B, R at true position")
    )
    return save(figure, f"ralad_fig{number}", out)


def _estimates(column: np.ndarray, data: xr.Dataset, sensor: str, quantity: str) -> None:
    """One sensor: every method above, the robust ones below."""
    parameter, factor = f"{sensor}.{quantity}", SHOWN[quantity][1]
    scans = 1 + np.arange(data.sizes["scan"])
    truth = factor * float(data["truth"].sel(parameter=parameter))
    median, error = mean_estimate(data, "LMedS", "true", parameter)
    for axes, methods in zip(column, (("RLS", "Huber", "RALAD"), ("Huber", "RALAD")), strict=True):
        ends = [truth, median - 1.96 * error, median + 1.96 * error]
        for method in methods:
            runs = data["path"].sel(recursion=method, reading="true", parameter=parameter)
            measured = bias(factor * runs.transpose("replicate", "scan").values, 0.0)
            _curve(axes, scans, measured, method)
            # the first scans are far off in every method and would flatten the rest
            ends += list(np.quantile(measured.value[len(scans) // 10 :], [0.0, 1.0]))
        axes.errorbar(scans[-1] * 1.02, median, 1.96 * error, fmt="D", markersize=4, capsize=2,
                      color=COLOURS["LMedS"], label="LMedS (batch)", clip_on=False)  # fmt: skip
        axes.axhline(truth, label="truth", **TRUTH)
        margin = 0.15 * (max(ends) - min(ends))
        axes.set_ylim(min(ends) - margin, max(ends) + margin)
        axes.set_xlim(0, scans[-1] * 1.03)


def _curve(axes: Axes, scans: np.ndarray, measured: Measured, method: str) -> None:
    """A mean over runs with its 95 % band."""
    band = 1.96 * measured.standard_error
    axes.plot(scans, measured.value, color=COLOURS[method], label=method)
    axes.fill_between(scans, measured.value - band, measured.value + band,
                      color=COLOURS[method], alpha=0.2, linewidth=0)  # fmt: skip


def draw_conditions(
    profile: str, results: Path, out: Path, *, number: int, case: int
) -> list[Path]:
    """Figures 7-8: ratio of condition numbers along a track, and what it amounts to."""
    data, manifest = load_case("ralad", case, profile, results)
    ratio = data["log_condition_ratio"].transpose("track", "replicate", "scan")
    scans = 1 + np.arange(ratio.sizes["scan"])
    figure, (left, right) = plt.subplots(1, 2, figsize=(WIDTH, 2.9), width_ratios=[1.5, 1])
    kinds = dict(zip(ratio["track"].values, (COLOURS["Huber"], COLOURS["RLS"]), strict=True))
    first = str(ratio["track"].values[0])
    left.vlines(scans, 0.0, ratio.sel(track=first)[0], color=kinds[first], linewidth=0.6)
    left.axhline(0.0, **TRUTH)
    left.set_xlabel("scan (0.1 s)")
    left.set_ylabel(r"$\log_{10}$ cond(Huber) / cond(RALAD)")
    left.set_title(f"a track {first}, one run")
    _ratios(right, ratio, kinds)
    shift = abs(data["theta_single_shift"]).max(("replicate", "recursion"))
    largest = float(shift.sel(parameter=["i.range", "j.range"]).max())
    text = (
        "cond($BPB'+R^{1/2}\\Psi^{-1}R^{1/2}$) over cond($BPB'+R$), as printed\nsingle precision "
        f"moves no range estimate of any method by more than {1e3 * largest:.0f} mm"
    )
    footnote(figure, _source(manifest, text))
    return save(figure, f"ralad_fig{number}", out)


def _ratios(axes: Axes, ratio: xr.DataArray, kinds: dict[str, str]) -> None:
    """Histogram over all runs, a colour for each kind of track."""
    edges = np.linspace(-1.0, 3.0, 81)
    for kind, colour in kinds.items():
        values = ratio.sel(track=kind).values.ravel()
        above, below = (values > 0.01).mean(), (values < -0.01).mean()
        text = f"{kind}\nabove 0.01: {above:.0%}, below $-$0.01: {below:.0%}"
        share = np.full(values.size, 1.0 / values.size)
        clipped = np.clip(values, edges[0], edges[-1])
        axes.hist(clipped, list(edges), histtype="step", color=colour, weights=share, label=text)
    axes.set_yscale("log")
    axes.set_ylim(top=8.0)
    axes.set_xlabel(r"$\log_{10}$ ratio")
    axes.set_ylabel("share of updates, all runs")
    axes.legend(fontsize=6.5, loc="upper right")


def _source(manifest: dict[str, Any], text: str) -> str:
    case, runs = manifest["config"]["case"], manifest["replicates"]
    return f"{SOURCE}, case {case}; {runs} runs; {text}"


FIGURES = {
    "ralad_fig1": partial(draw_estimates, number=1, case=1, quantity="range"),
    "ralad_fig2": partial(draw_estimates, number=2, case=1, quantity="azimuth"),
    "ralad_fig3": partial(draw_estimates, number=3, case=1, quantity="elevation"),
    "ralad_fig4": partial(draw_estimates, number=4, case=2, quantity="range"),
    "ralad_fig5": partial(draw_estimates, number=5, case=2, quantity="azimuth"),
    "ralad_fig6": partial(draw_estimates, number=6, case=2, quantity="elevation"),
    "ralad_fig7": partial(draw_conditions, number=7, case=1),
    "ralad_fig8": partial(draw_conditions, number=8, case=2),
}
