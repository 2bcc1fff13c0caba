"""Heights by pressure that targets report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors._kind import Kind
from probreg.sensors.heights import FOOT_M, STEPS_M, quantisation_variance
from probreg.sensors.kinds._height import HeightSensor
from probreg.typing import FloatArray

ROUNDING_M = float(np.sqrt(quantisation_variance(STEPS_M[0])))  # of the coarsest steps


@dataclass(frozen=True)
class Barometer(HeightSensor):
    """Heights by pressure: off by the weather, by an offset and a share of the height.

    Both are common to a recording, and estimated unless the setup says otherwise. Heights come in
    steps of 25 or 100 feet, and a level flight rounds alike all the time, so what is left of the
    height is a constant of each target.

    Parameters
    ----------
    sigma_height : float
        Standard deviation of a height beside offset and share, metres.
    name : str
        Prefix of its bias names, "name.height" and "name.height_gain".

    Raises
    ------
    InvalidInputError
        A sigma that is not positive.
    """

    sigma_height: float
    name: str = "barometer"

    kind: ClassVar[Kind] = Kind(
        "barometer",
        ("pressure_altitude_m",),
        {"sigma_height_m": "sigma_height"},
        others={"flight_level": 100.0 * FOOT_M},
        beside=10.0,
        terms=("height", "height_gain"),
        constants={"height": ROUNDING_M},
    )

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 60 m, from one day's weather to another's."""
        return np.array([60.0])
