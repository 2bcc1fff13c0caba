"""Results of studies whose replicates are blocks of runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr

from experiments.results import load_result


def load_cases(study: str, label: str, results: Path) -> tuple[xr.Dataset, dict[str, Any]]:
    """Results with blocks and runs joined to one dimension "case", and their manifest."""
    data, manifest = load_result(study, label, results)
    return data.stack(case=("replicate", "run"), create_index=False), manifest


def runs_of(manifest: dict[str, Any]) -> int:
    """Number of Monte Carlo runs behind a result."""
    config = manifest["config"]
    return int(config["replicates"] * config["runs"])
