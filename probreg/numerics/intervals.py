"""Intervals of draws."""

from __future__ import annotations

import numpy as np

from probreg.typing import FloatArray
from probreg.validation import open_share


def equal_tailed(draws: FloatArray, probability: float, axis: tuple[int, ...]) -> FloatArray:
    """Equal-tailed intervals over some axes of draws: the axes that are left, and 2.

    Raises
    ------
    InvalidInputError
        A probability out of (0, 1).
    """
    tail = 0.5 * (1.0 - open_share("probability", probability))
    return np.moveaxis(np.quantile(draws, [tail, 1.0 - tail], axis=axis), 0, -1)
