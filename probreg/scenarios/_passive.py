"""What the bearings-only scenes share: an emitter at rest, seen from a moving platform."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors import BearingSensor
from probreg.sensors.reports import BearingReports
from probreg.typing import BoolArray, FloatArray, IntArray

# first and last report (numbered as the paper does) and size in standard deviations
OutlierTable = tuple[tuple[int, int, float], ...]


@dataclass(frozen=True, eq=False)
class PassiveTruth:
    """Ground truth, hidden from the estimators.

    Attributes
    ----------
    emitter : ndarray, shape (2,)
    bias : float
        Of the sensor's bearings, radians.
    bearing : ndarray, shape (n,)
        Without bias and noise.
    outlier : ndarray of bool, shape (n,)
    """

    emitter: FloatArray
    bias: float
    bearing: FloatArray
    outlier: BoolArray


def sizes(table: OutlierTable, numbers: IntArray) -> FloatArray:
    """Outlier size of each numbered report, zero where there is none, shape (n,)."""
    found = np.zeros(len(numbers))
    for first, last, size in table:
        chosen = (numbers >= first) & (numbers <= last)
        if not chosen.any():
            raise InvalidInputError(f"the outliers {first} to {last} lie outside the recording.")
        found[chosen] = size
    return found


def report(
    sensor: BearingSensor,
    emitter: tuple[float, float],
    own: FloatArray,
    time: FloatArray,
    bias: float,
    error: FloatArray,
    outlier: BoolArray,
) -> tuple[BearingReports, PassiveTruth]:
    """Bearings with errors in standard deviations (n,), and the truth behind them."""
    place = np.array(emitter, dtype=float)
    bearing = sensor.to_report(np.broadcast_to(place, own.shape), own)[:, 0]
    reported = bearing + bias + sensor.sigma_bearing * error
    data = BearingReports(sensor, reported, own, time)
    return data, PassiveTruth(place, bias, bearing, outlier)
