"""Errors and shares over runs, each with its standard error, and how they are drawn."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from probreg.typing import FloatArray, IntArray

ONLINE, WHOLE = "#0072B2", "#D55E00"  # from what was seen so far, from all scans


def mean_and_error(values: xr.DataArray) -> tuple[float, float]:
    """Mean over runs ("case") and all else, and its standard error; NaN if any value is."""
    runs = values.mean([d for d in values.dims if d != "case"], skipna=False).values
    return float(runs.mean()), float(runs.std() / np.sqrt(len(runs)))


def rmse(square: xr.DataArray) -> tuple[float, float]:
    """Root mean square error over runs ("case") and all else, and its standard error."""
    mean, error = mean_and_error(square)
    value = float(np.sqrt(mean))
    return value, error / (2.0 * value)


def error_bars(axes: plt.Axes, at: IntArray, values: FloatArray, colours: Sequence[str]) -> None:
    """Points with two standard errors; values (n, 2)."""
    for y, (value, error), colour in zip(at, values, colours, strict=True):
        axes.errorbar(value, y, xerr=2.0 * error, fmt="o", color=colour, markersize=4, capsize=2)
