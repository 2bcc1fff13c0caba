"""Remarks on what a recording is like and on biases that priors did not foresee."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from probreg.recordings import Recording
from probreg.recordings.checks import several_at_once
from probreg.typing import FloatArray

FAR_SIGMAS = 5.0  # of the prior, from zero


def at_once_notes(recording: Recording) -> list[str]:
    """Say which sensors give one target several reports at one time: both cannot be."""
    return [
        f"{sensor.name} gives one target two reports at one time in {count} cases; identities or "
        "plot extraction need a look."
        for sensor, count in zip(recording.sensors, several_at_once(recording), strict=True)
        if count
    ]


def far_notes(names: Sequence[str], mean: FloatArray, prior_sd: FloatArray) -> list[str]:
    """Say which biases are much larger than their prior allows."""
    size = np.abs(mean) / prior_sd
    return [
        f"{names[k]} is {size[k]:.0f} prior standard deviations from zero: check from_north, the "
        "place of the sensor and the units, or enlarge its prior_sd."
        for k in np.flatnonzero(size > FAR_SIGMAS).tolist()
    ]
