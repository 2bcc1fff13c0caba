"""What the figures of the LTS paper share: where results are, and what is said of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr

from paper_figs._cases import load_cases, runs_of

SOURCE = "Tian and Huang, J. Electronics & Information Technology 40(3), 2018"
READINGS = ("literal", "symmetric")
BREAKDOWN = 0.25  # share of wrong pairs that LTS with 75 % coverage still bears


def load(
    study: str, reading: str, profile: str, results: Path
) -> tuple[xr.Dataset, dict[str, Any]]:
    """Results of one reading, by case."""
    return load_cases(study, f"{profile},reading={reading}", results)


def suffix(reading: str) -> str:
    """Ending of the file name: the literal reading has none."""
    return "" if reading == "literal" else f"_{reading}"


def source(manifest: dict[str, Any], text: str) -> str:
    """Footnote: where the numbers come from."""
    reading = manifest["config"]["reading"]
    place = "(0, 80)" if reading == "literal" else "(50, 80)"
    where = f"{reading} reading: square centred at {place} km; {runs_of(manifest)} runs"
    return f"{SOURCE}\n{where}; few wrong pairs: at most {BREAKDOWN:.0%}\n{text}"
