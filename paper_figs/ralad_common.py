"""What the figures of the RALAD paper share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from experiments.results import load_result
from paper_figs.style import COLOURS, TRUTH, WIDTH, footnote, save
from probreg.diagnostics import Measured, bias

SOURCE = "Guo et al., Control and Decision (2017)"
# each bias in the unit that the paper prints
SHOWN = {"range": ("range", 1.0, "m"), "azimuth": ("azimuth", 1e3, "mrad"),
         "elevation": ("elevation", 1e3, "mrad")}  # fmt: skip
PARAMETERS = [f"{sensor}.{name}" for sensor in "ij" for name in SHOWN]


def load_case(
    study: str, case: int, profile: str, results: Path
) -> tuple[xr.Dataset, dict[str, Any]]:
    """Results of one case and their manifest."""
    return load_result(study, f"{profile},case={case}", results)


def unit_factor(parameter: str) -> float:
    """From SI to the unit shown."""
    return SHOWN[parameter.split(".")[1]][1]


def mean_and_error(
    data: xr.Dataset, method: str, reading: str, parameter: str
) -> tuple[float, float]:
    """Mean estimate over runs and its standard error, in the unit shown."""
    theta = data["theta"].sel(estimator=method, reading=reading, parameter=parameter)
    measured = bias(theta.values, 0.0)
    factor = unit_factor(parameter)
    return factor * float(measured.value), factor * float(measured.standard_error)


def draw_estimates(
    name: str, case: int, quantity: str, profile: str, results: Path, out: Path
) -> list[Path]:
    """Figures 1-6: mean estimate of one bias of both sensors against the scan."""
    data, manifest = load_case("ralad", case, profile, results)
    label, factor, unit = SHOWN[quantity]
    scans = 1 + np.arange(data.sizes["scan"])
    figure, grid = plt.subplots(2, 2, figsize=(WIDTH, 4.6), sharex=True)
    for column, sensor in zip(grid.T, "ij", strict=True):
        parameter = f"{sensor}.{quantity}"
        truth = factor * float(data["truth"].sel(parameter=parameter))
        median, error = mean_and_error(data, "LMedS", "true", parameter)
        for axes, methods in zip(
            column, (("RLS", "Huber", "RALAD"), ("Huber", "RALAD")), strict=True
        ):
            ends = [truth, median - 1.96 * error, median + 1.96 * error]
            for method in methods:
                runs = data["path"].sel(recursion=method, reading="true", parameter=parameter)
                measured = bias(factor * runs.transpose("replicate", "scan").values, 0.0)
                _curve(axes, scans, measured, method)
                # the first scans are far off in every method and would flatten the rest
                ends += list(np.quantile(measured.value[len(scans) // 10 :], [0.0, 1.0]))
            axes.errorbar(scans[-1] * 1.02, median, 1.96 * error, fmt="D", markersize=4,
                          capsize=2, color=COLOURS["LMedS"], label="LMedS (batch)",
                          clip_on=False)  # fmt: skip
            axes.axhline(truth, label="truth", **TRUTH)
            margin = 0.15 * (max(ends) - min(ends))
            axes.set_ylim(min(ends) - margin, max(ends) + margin)
            axes.set_xlim(0, scans[-1] * 1.03)
            axes.set_ylabel(f"{label} bias ({unit})")
        column[0].set_title(f"sensor {sensor}")
        column[1].set_title("without RLS")
        column[1].set_xlabel("scan (0.1 s)")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=5)
    footnote(
        figure, _source(manifest, "mean estimate, band: 95 % of the mean; B, R at true position")
    )
    return save(figure, name, out)


def _curve(axes: Axes, scans: np.ndarray, measured: Measured, method: str) -> None:
    """A mean over runs with its 95 % band."""
    band = 1.96 * measured.standard_error
    axes.plot(scans, measured.value, color=COLOURS[method], label=method)
    axes.fill_between(scans, measured.value - band, measured.value + band,
                      color=COLOURS[method], alpha=0.2, linewidth=0)  # fmt: skip


def draw_conditions(name: str, case: int, profile: str, results: Path, out: Path) -> list[Path]:
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
    edges = np.linspace(-1.0, 3.0, 81)
    for kind, colour in kinds.items():
        values = ratio.sel(track=kind).values.ravel()
        above, below = (values > 0.01).mean(), (values < -0.01).mean()
        text = f"{kind}\nabove 0.01: {above:.0%}, below $-$0.01: {below:.0%}"
        share = np.full(values.size, 1.0 / values.size)
        clipped = np.clip(values, edges[0], edges[-1])
        right.hist(clipped, edges, histtype="step", color=colour, weights=share, label=text)
    right.set_yscale("log")
    right.set_ylim(top=8.0)
    right.set_xlabel(r"$\log_{10}$ ratio")
    right.set_ylabel("share of updates, all runs")
    right.legend(fontsize=6.5, loc="upper right")
    shift = abs(data["theta_single_shift"]).max(("replicate", "recursion"))
    largest = float(shift.sel(parameter=["i.range", "j.range"]).max())
    text = (
        "cond($BPB'+R^{1/2}\\Psi^{-1}R^{1/2}$) over cond($BPB'+R$), as printed\nsingle precision "
        f"moves no range estimate of any method by more than {1e3 * largest:.0f} mm"
    )
    footnote(figure, _source(manifest, text))
    return save(figure, name, out)


def _source(manifest: dict[str, Any], text: str) -> str:
    case, runs = manifest["config"]["case"], manifest["replicates"]
    return f"{SOURCE}, case {case}; {runs} runs; {text}"
