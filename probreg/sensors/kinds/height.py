"""Geometric heights that targets report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors._kind import Kind
from probreg.sensors.kinds._height import HeightSensor
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Height(HeightSensor):
    """Heights above the ellipsoid, or above the plane of a frame without an origin.

    A reference unless the setup asks for its offset.

    Parameters
    ----------
    sigma_height : float
        Standard deviation of a height, metres.
    name : str
        Prefix of its bias name, "name.height".

    Raises
    ------
    InvalidInputError
        A sigma that is not positive.
    """

    sigma_height: float
    name: str = "height"

    kind: ClassVar[Kind] = Kind(
        "height", ("height_m",), {"sigma_height_m": "sigma_height"}, beside=10.0, terms=()
    )

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior: 30 m, as between an ellipsoid and a geoid that was forgotten."""
        return np.array([30.0])
