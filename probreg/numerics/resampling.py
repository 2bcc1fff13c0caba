"""Systematic resampling."""

from __future__ import annotations

import numpy as np

from probreg.typing import FloatArray, IntArray


def systematic(share: FloatArray, wanted: int, rng: np.random.Generator) -> IntArray:
    """Numbers of resampled proposals: each appears within one of its expected count."""
    edges = np.cumsum(share / share.sum())
    edges[-1] = 1.0
    return np.searchsorted(edges, (np.arange(wanted) + rng.random()) / wanted)
