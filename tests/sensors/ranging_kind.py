"""A kind of sensor that the package does not have: a station that reports distances only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from probreg.sensors import Equations, Kind
from probreg.sensors.axes import polar_axes
from probreg.validation import finite_array


@dataclass(frozen=True)
class Ranging:
    position: tuple[float, float]
    sigma_range: float
    name: str = "ranging"

    kind: ClassVar[Kind] = Kind(
        "ranging", ("range_m",), {"sigma_range_m": "sigma_range"}, coordinates=2
    )
    dim: ClassVar[int] = 2
    bias_names: ClassVar[tuple[str, ...]] = ("range",)
    bias_units: ClassVar[tuple[str, ...]] = ("m",)
    azimuth_column: ClassVar[int | None] = None
    from_north: ClassVar[bool] = False
    gives_position: ClassVar[bool] = False
    cartesian: ClassVar[bool] = False

    @property
    def sigmas(self):
        return np.array([self.sigma_range])

    @property
    def principal(self):
        return self.sigmas, None

    @property
    def bias_sd(self):
        return np.array([100.0])

    def check(self, reports):
        return finite_array(f"ranges of sensor {self.name!r}", reports, (None, 1))

    def to_cartesian(self, reports, own=None, *, unbiased=True):
        return np.full((len(reports), 2), np.nan)

    def _line(self, positions, own):
        return positions - np.asarray(self.position) - (0.0 if own is None else own)

    def to_report(self, positions, own=None):
        return np.linalg.norm(self._line(positions, own), axis=1, keepdims=True)

    def axes(self, site):
        return polar_axes(self.position, ("range",), False, site)

    def observe(self, reports, at=None, own=None):
        n = len(reports)
        e, G, C, D = np.zeros((n, 2)), np.zeros((n, 2, 2)), np.zeros((n, 2, 2)), np.zeros((n, 2, 1))
        if at is None:
            return Equations(e, G, C, D)
        line = self._line(at, own)
        distance = np.linalg.norm(line, axis=1)
        G[:, 0] = line / distance[:, None]
        e[:, 0] = reports[:, 0] - distance + np.einsum("nd,nd->n", G[:, 0], at)
        C[:, 0, 0], D[:, 0, 0] = self.sigma_range**2, 1.0
        return Equations(e, G, C, D)

    def report_sd(self, reports):
        return np.broadcast_to(self.sigmas, np.shape(reports))

    def sample_noise(self, rng, n, at=None):
        return self.sigma_range * rng.standard_normal((n, 1))
