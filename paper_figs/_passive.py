"""What the figures of the two bearings-only papers share: errors, bound, panels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper_figs._style import BOUND, PASSIVE_COLOURS, TRUTH, WIDTH
from probreg.typing import FloatArray

FILTER_SOURCE = "Zhang, Chen, Wu and Zhang, J. Air Force Engineering Univ. 15(4), 2014"
TOTAL_SOURCE = "Wu, Chen, Zhang, Zhang and Ni, J. Central South Univ. 46(3), 2015"
SIGMAS = (0.1, 1.0)
PERCENT = 100.0 / 180_000.0  # of the emitter's distance from the track, in the second paper
READING_TITLES = {
    "none": "no outliers",
    "random": "outliers N(0, (k sigma)^2)",
    "one_sided": "outliers + k sigma",
}


def root_mean(square: xr.DataArray, dim: str = "case") -> FloatArray:
    """Root mean square error from squared errors."""
    return np.sqrt(square.mean(dim, skipna=False).values)


def root_median(square: xr.DataArray, dim: str = "case") -> FloatArray:
    """Median error from squared errors."""
    return np.sqrt(square.median(dim, skipna=False).values)


def root_bound(data: xr.Dataset, dim: str) -> FloatArray:
    """Bound after each bearing, root of the trace; the same in every replicate."""
    return np.sqrt(data["squared_bound"].isel(case=0).transpose(dim).values)


def curve(axes: Axes, x: FloatArray, y: FloatArray, name: str, **style: Any) -> None:
    """Draw one method in its colour."""
    axes.plot(x, y, color=PASSIVE_COLOURS[name], label=name, **style)


def draw_curves(
    axes: Axes,
    data: xr.Dataset,
    dim: str,
    methods: Sequence[str],
    measure: Callable[[xr.DataArray], FloatArray],
    scale: float = 1.0,
) -> dict[str, FloatArray]:
    """Draw the error of each method and the bound against `dim`; gives the errors drawn."""
    x = data[dim].values
    drawn = {}
    for name in methods:
        drawn[name] = scale * measure(data["squared_error"].sel(estimator=name))
        curve(axes, x, drawn[name], name)
    axes.plot(x, scale * root_bound(data, dim), label="Cramér-Rao bound", **BOUND)
    axes.set_yscale("log")
    return drawn


def draw_geometry(
    axes: Axes, own: FloatArray, emitter: FloatArray, bearings: FloatArray, rows: list[int]
) -> None:
    """Draw the track, the emitter and some lines of sight, in kilometres."""
    own, emitter = 1e-3 * own, 1e-3 * emitter
    axes.plot(*own.T, **TRUTH, label="own track")
    axes.plot(*own[0], "k>", markersize=6)
    length = 1.15 * np.linalg.norm(emitter - own, axis=1).max()
    for row in rows:
        end = own[row] + length * np.array([np.cos(bearings[row]), np.sin(bearings[row])])
        label = "line of sight, as reported" if row == rows[0] else None
        axes.plot(*np.stack([own[row], end]).T, color="C0", linewidth=0.7, label=label)
        axes.plot(*own[row], ".", color="C0")
    axes.plot(*emitter, "*", color=PASSIVE_COLOURS["RRTLS"], markersize=11, label="emitter")
    axes.set_xlabel("x (km)")
    axes.set_ylabel("y (km)")


def grid(rows: int, columns: int, height: float) -> tuple[Figure, Any]:
    """Panels that share their x axis."""
    figure, panels = plt.subplots(
        rows, columns, figsize=(WIDTH, height), sharex=True, squeeze=False
    )
    return figure, panels
