"""An eccentric azimuth encoder: the cosine of the azimuth, added to the azimuth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.sensors.terms._azimuth_wave import AzimuthWave
from probreg.typing import FloatArray


@dataclass(frozen=True)
class AzimuthCosine(AzimuthWave):
    """An eccentric azimuth encoder: the cosine of the azimuth, added to the azimuth."""

    @property
    def name(self) -> str:
        """Name of the term."""
        return "azimuth_cosine"

    def wave(self, azimuth: FloatArray) -> FloatArray:
        """The cosine."""
        return np.cos(azimuth)
