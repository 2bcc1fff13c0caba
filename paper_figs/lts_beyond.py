"""Beyond the LTS paper: every estimator against the bound, with failure rates."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from paper_figs._lts import BREAKDOWN, READINGS, load, source, suffix
from paper_figs._style import BOUND, WIDTH, footnote, name_rows, save, shared_legend
from paper_figs._tables import save_table
from probreg.typing import FloatArray

FAILURE = 6.0  # standard deviations of the bound beyond which an estimate has failed
MARKERS = {"all runs": "o", "few wrong pairs": "s", "median": "D"}


def draw(profile: str, results: Path, out: Path) -> list[Path]:
    """Draw one figure and one table a reading."""
    paths = []
    for reading in READINGS:
        data, manifest = load("lts_beyond", reading, profile, results)
        found = compare(data)
        names = [str(m) for m in data["estimator"].values]
        figure, panels = plt.subplots(1, len(data["sigma"]), figsize=(WIDTH, 4.0), sharey=True)
        for axes, sigma in zip(panels, data["sigma"].values, strict=True):
            for y, name in enumerate(names):
                *ratios, failed = found[name, float(sigma)]
                for ratio, marker in zip(ratios, MARKERS.values(), strict=True):
                    axes.plot(ratio, y, marker, color="C0", markersize=4,
                              fillstyle="full" if marker == "o" else "none")  # fmt: skip
                axes.annotate(f"{failed:.1%}", (1.0, y), xycoords=("axes fraction", "data"),
                              ha="right", va="center", fontsize=6.5)  # fmt: skip
            axes.axvline(1.0, **BOUND)
            axes.set_xscale("log")
            axes.set_xlim(0.7, 200.0)
            axes.set_title(f"sigma = {sigma:.0f} m")
            axes.set_xlabel("error over bound")
        name_rows(panels[0], names)
        for label, marker in MARKERS.items():
            fill = "full" if marker == "o" else "none"
            panels[0].plot([], [], marker, color="C0", markersize=4, fillstyle=fill, label=label)
        shared_legend(figure, panels[0], len(MARKERS))
        text = f"right: share of runs with an error beyond {FAILURE:.0f} bounds in any parameter"
        footnote(figure, source(manifest, text))
        paths += save(figure, f"lts_beyond{suffix(reading)}", out)
        paths += _table(reading, names, found, source(manifest, text), out)
    return paths


def compare(data: xr.Dataset) -> dict[tuple[str, float], tuple[float, float, float, float]]:
    """Errors over the bound (all runs, few wrong pairs, median) and failure rates.

    The four parameters are pooled after division by each one's bound.
    """
    found = {}
    dims = ("case", "parameter")
    for sigma in data["sigma"].values:
        at = data.sel(sigma=sigma)
        sd: FloatArray = at["bound_sd"].transpose(*dims).values
        few = at["wrong_share"].values <= BREAKDOWN
        for name in data["estimator"].values:
            theta = at["theta"].sel(estimator=name).transpose(*dims).values
            errors = theta - data["truth"].values
            z = np.abs(errors) / sd
            found[str(name), float(sigma)] = (
                _rms_ratio(errors, sd),
                _rms_ratio(errors[few], sd[few]),
                float(np.mean(np.median(z, axis=0)) / 0.6745),
                float(np.mean(z.max(axis=1) > FAILURE)),
            )
    return found


def _rms_ratio(errors: FloatArray, sd: FloatArray) -> float:
    """RMSE over the bound's, by parameter, then their quadratic mean."""
    return float(np.sqrt(np.mean(np.mean(errors**2, axis=0) / np.mean(sd**2, axis=0))))


def _table(
    reading: str,
    names: list[str],
    found: dict[tuple[str, float], tuple[float, float, float, float]],
    note: str,
    out: Path,
) -> list[Path]:
    sigmas = sorted({sigma for _, sigma in found})
    header = ["error over bound"]
    for sigma in sigmas:
        header += [f"{sigma:.0f} m: all", "few wrong", "median", "failed"]
    rows = []
    for name in names:
        row = [name]
        for sigma in sigmas:
            *ratios, failed = found[name, sigma]
            row += [*(f"{ratio:.2f}" for ratio in ratios), f"{failed:.2%}"]
        rows.append(row)
    title = f"Beyond the LTS paper, {reading} reading"
    return save_table(f"lts_beyond_table{suffix(reading)}", title, header, rows, note, out)
