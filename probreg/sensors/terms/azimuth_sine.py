"""An eccentric azimuth encoder: the sine of the azimuth, added to the azimuth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.sensors.terms._azimuth_wave import AzimuthWave
from probreg.typing import FloatArray


@dataclass(frozen=True)
class AzimuthSine(AzimuthWave):
    """An eccentric azimuth encoder: the sine of the azimuth, added to the azimuth."""

    @property
    def name(self) -> str:
        """Name of the term."""
        return "azimuth_sine"

    def wave(self, azimuth: FloatArray) -> FloatArray:
        """The sine."""
        return np.sin(azimuth)
