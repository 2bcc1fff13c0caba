"""Barometric heights: the steps they are reported in, and what is known of their error.

report = height + offset + share * height + rounding. Offset and share are of the weather and
common to a recording; rounding is of each report, but a level flight repeats it.
"""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_number

FOOT_M = 0.3048
STEPS_M = (100.0 * FOOT_M, 25.0 * FOOT_M)  # of Mode C, and of Mode S and ADS-B
ENOUGH = 20  # heights, to tell a step: chance fits so many with probability 1e-17
_ROUNDED_M = 0.5  # whole metres in a table


def quantisation_step(heights: FloatArray) -> float:
    """Coarsest step, metres, of which all heights are multiples; zero where there is none.

    Parameters
    ----------
    heights : ndarray, shape (n,)
        Barometric heights of one aircraft or of many that report alike, metres; they may have
        been rounded to whole metres. Fewer than `ENOUGH` different reports tell no step.
    """
    heights = finite_array("heights", heights, (None,))
    if heights.size < ENOUGH:
        return 0.0
    for step in STEPS_M:
        left = np.abs(heights - step * np.rint(heights / step))
        if left.max() <= _ROUNDED_M:
            return step
    return 0.0


def quantisation_variance(step: float) -> float:
    """Variance of what rounding to a step adds, in the square of its unit: step^2 / 12.

    It belongs to each report of a climb, and to the offset of a level flight, whose reports are
    all rounded alike.
    """
    return positive_number("step", step, zero=True) ** 2 / 12.0


def error_at(mean: FloatArray, covariance: FloatArray, height: float) -> tuple[float, float]:
    """Mean and standard deviation, metres, of the barometric error at a height.

    En route, where all fly at much the same height, offset and share are hardly told apart; their
    sum at that height is what the recording determines.

    Parameters
    ----------
    mean : ndarray, shape (2,)
        Of offset (metres) and share of height.
    covariance : ndarray, shape (2, 2)
    height : float
        Metres.

    Raises
    ------
    InvalidInputError
        Wrong shapes, or a covariance that makes a variance negative.
    """
    mean = finite_array("mean", mean, (2,))
    covariance = finite_array("covariance", covariance, (2, 2))
    row = np.array([1.0, height])
    variance = float(row @ covariance @ row)
    if variance < 0.0:
        raise InvalidInputError(
            f"the variance of the error at {height:g} m is {variance:.3g}; pass a covariance of "
            "offset and share."
        )
    return float(row @ mean), float(np.sqrt(variance))
