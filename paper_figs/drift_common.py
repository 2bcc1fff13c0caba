"""What the figures of drifting biases share."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

from probreg.typing import FloatArray, IntArray

ONLINE, WHOLE = "#0072B2", "#D55E00"


def rmse(square: xr.DataArray) -> tuple[float, float]:
    """Root mean square error over runs ("case") and all else, and its standard error."""
    runs = square.mean([d for d in square.dims if d != "case"]).values
    value = float(np.sqrt(runs.mean()))
    return value, float(runs.std() / np.sqrt(len(runs)) / (2.0 * value))


def error_bars(axes: plt.Axes, at: IntArray, values: FloatArray, colours: Sequence[str]) -> None:
    """Points with two standard errors; values (n, 2)."""
    for y, (value, error), colour in zip(at, values, colours, strict=True):
        axes.errorbar(value, y, xerr=2.0 * error, fmt="o", color=colour, markersize=4, capsize=2)
