"""How far the median of a few numbers is from the truth, beside their mean.

Figure `median_error` is drawn from it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr


@dataclass(frozen=True)
class Config:
    """A replicate is one sample."""

    size: int = 11
    replicates: int = 200
    seed: int = 20261124

    def resolved(self) -> dict[str, Any]:
        """Every number that the results depend on, for the manifest."""
        return dataclasses.asdict(self)


PROFILES = {"quick": Config(replicates=20), "paper": Config()}
GRID = {"size": (11, 101)}


def replicate(config: Config, rng: np.random.Generator) -> xr.Dataset:
    """Errors of mean and median of a Student-t sample."""
    sample = rng.standard_t(3.0, config.size)
    return xr.Dataset({"error": ("method", [sample.mean(), np.median(sample)])},
                      {"method": ["mean", "median"]})  # fmt: skip
