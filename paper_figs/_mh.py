"""What the figures of the Metropolis-Hastings paper share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr

from paper_figs._cases import load_cases

SOURCE = "Zhou, Liang and Pan, Systems Engineering and Electronics 34(3), 2012"
FORM_TITLES = {"reference": "B: target known", "pair": "C: second, calibrated sensor"}
MH_COLOURS = {
    "uncorrected": "#888888",
    "paper's protocol": "#D55E00",
    "flat prior, chain mean": "#E69F00",
    "sequential MH": "#0072B2",
    "Kalman filter": "#009E73",
    "RTS smoother": "#CC79A7",
}
TARGET_COLOURS = {
    "flat": MH_COLOURS["flat prior, chain mean"],
    "sequential": MH_COLOURS["sequential MH"],
}


def load(drifting: bool, profile: str, results: Path) -> tuple[xr.Dataset, dict[str, Any]]:
    """Every method on the scene with a drifting or a constant bias."""
    return load_cases("mh", f"{profile},drifting={drifting}", results)
