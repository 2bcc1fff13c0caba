"""What the figures and tables of the RALAD paper share: loading, units, mean estimates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr

from experiments.results import load_result
from probreg.diagnostics import bias

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


def mean_estimate(
    data: xr.Dataset, method: str, reading: str, parameter: str
) -> tuple[float, float]:
    """Mean estimate over runs and its standard error, in the unit shown."""
    theta = data["theta"].sel(estimator=method, reading=reading, parameter=parameter)
    measured = bias(theta.values, 0.0)
    factor = unit_factor(parameter)
    return factor * float(measured.value), factor * float(measured.standard_error)
