"""Real recordings: biases of radar, lidar and cameras against GNSS, scenario by scenario."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from experiments.results import load_result
from paper_figs._style import WIDTH, footnote, save, shared_legend
from paper_figs._tables import save_table

NEEDS = "PROBREG_DATA"  # the recordings are not part of the project
SOURCE = "Autoferry sensor-fusion benchmark, Ocean Engineering (2022)"
BLUE, RED, GREY = "#0072B2", "#D55E00", "0.45"


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one panel a bias: posterior, direct offset, and what the scenarios have in common."""
    data, _ = load_result("autoferry", profile, results)
    data = data.isel(replicate=0)
    figure, grid = plt.subplots(2, 3, figsize=(1.2 * WIDTH, 5.2))
    scenarios = [int(s) for s in data["scenario"].values]
    rows: list[list[str]] = []
    for axes, bias in zip(grid.ravel(), (str(b) for b in data["bias"].values), strict=True):
        one = data.sel(bias=bias)
        scale, unit = (1.0, "m") if bias.endswith("range") else (180.0 / np.pi, "deg")
        posterior, direct = scale * one["posterior"].values, scale * one["direct"].values
        _panel(axes, posterior, direct, scale * one["pooled"].values)
        if bias.startswith("radar."):
            _against_lidar(axes, scale * data["relative"].sel(component=bias).values)
        axes.set_title(f"{bias} ({unit})")
        axes.set_xticks([*range(len(scenarios)), len(scenarios) + 0.5],
                        [*map(str, scenarios), "all"])  # fmt: skip
        rows.append([f"{bias} ({unit})"])
        own = scale * data["own"].sel(polar=bias).values if bias in data["polar"] else None
        rows += [_row(s, k, one, scale, own) for k, s in enumerate(scenarios)]
    for axes in grid[-1]:
        axes.set_xlabel("scenario")
    shared_legend(figure, grid[0, 0], 3, fontsize=7)
    note = (
        f"{SOURCE}. Direct: median of report minus GNSS, two standard errors from blocks of 10 s"
        "\nScenarios differ: heading was not recorded, and a vessel is larger than its antenna. "
        "Cameras see much besides"
    )
    footnote(figure, note)
    paths = save(figure, "autoferry_bias", out)
    header = [
        "scenario",
        "posterior",
        "direct",
        "posterior, target terms",
        "uncorrected",
        "own bias (in sample)",
        "the others' bias",
    ]
    title = "Autoferry: biases, and median absolute residual after correction"
    return paths + save_table("autoferry_table", title, header, rows, note, out)


def _panel(axes: plt.Axes, posterior: np.ndarray, direct: np.ndarray, pooled: np.ndarray) -> None:
    at = np.arange(len(posterior))
    bars = np.abs(posterior[:, 2:].T - posterior[:, 0])
    axes.errorbar(at, posterior[:, 0], bars, fmt="o", color=BLUE, markersize=4, capsize=2,
                  label="posterior, 90 %")  # fmt: skip
    axes.errorbar(at - 0.25, direct[:, 0], 2.0 * direct[:, 1], fmt="s", color=GREY, markersize=3.5,
                  capsize=2, label="direct, from GNSS")  # fmt: skip
    end = len(posterior) + 0.5
    axes.plot([end - 0.2] * 2, pooled[0], color=BLUE, linewidth=4, label="common, 90 %")
    axes.plot(
        [end + 0.2] * 2, pooled[2], color="#56B4E9", linewidth=2, label="a new scenario, 90 %"
    )
    axes.axhline(0.0, color="0.6", linewidth=0.6)


def _against_lidar(axes: plt.Axes, apart: np.ndarray) -> None:
    """Radar against lidar: lidar has a bias too, and this is the difference of the two."""
    at = np.arange(len(apart)) + 0.25
    bars = np.abs(apart[:, 2:].T - apart[:, 0])
    axes.errorbar(at, apart[:, 0], bars, fmt="^", color=RED, markersize=3.5, capsize=2,
                  label="posterior, radar against lidar")  # fmt: skip


def _row(scenario: int, k: int, one: xr.Dataset, scale: float, own: np.ndarray | None) -> list[str]:
    posterior, direct, score = (
        scale * one[name].values[k] for name in ("posterior", "direct", "score")
    )
    return [
        f"  {scenario}",
        f"{posterior[0]:.2f} ± {posterior[1]:.2f}",
        f"{direct[0]:.2f} ± {direct[1]:.2f}",
        "" if own is None else f"{own[k, 0]:.2f} ± {own[k, 1]:.2f}",
        *(f"{value:.2f}" for value in score),
    ]
