"""What every sensor offers, and the checks that they share."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from probreg.typing import FloatArray
from probreg.validation import angle_sigma, finite_array, positive_number


class Sensor(Protocol):
    """What a registration problem asks of a sensor.

    A report has `len(bias_names)` components; a bias adds to each of them.
    """

    @property
    def name(self) -> str:
        """Prefix of its bias names."""

    @property
    def dim(self) -> int:
        """Number of Cartesian coordinates."""

    @property
    def bias_names(self) -> tuple[str, ...]:
        """Names of the biases, one a report component."""

    @property
    def bias_units(self) -> tuple[str, ...]:
        """Units of the biases, "m" or "rad"."""

    @property
    def bias_sd(self) -> FloatArray:
        """Default prior standard deviation of each bias: what such sensors are found to have."""

    def check(self, reports: FloatArray) -> FloatArray:
        """Return reports, shape (n, q), after checking them."""

    def to_cartesian(self, reports: FloatArray, *, unbiased: bool = True) -> FloatArray:
        """Convert reports (n, q) to positions (n, d) in the common frame."""

    def to_report(self, positions: FloatArray) -> FloatArray:
        """Convert positions (n, d) in the common frame to noise-free reports (n, q)."""

    def sensitivity(self, positions: FloatArray) -> FloatArray:
        """Derivative (n, d, q) of the converted position with respect to the bias."""

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, d, d) of the converted position."""

    def sample_noise(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Draw n errors of reports, shape (n, q)."""


def settle(sensor: Any, dim: int, *sigmas: str) -> None:
    """Check a radar's numbers and store them as floats, so that equal sensors compare equal."""
    owner = f"of sensor {sensor.name!r}"
    position = finite_array(f"position {owner}", sensor.position, (dim,))
    object.__setattr__(sensor, "position", tuple(position.tolist()))
    for name in sigmas:
        check = positive_number if name == "sigma_range" else angle_sigma
        object.__setattr__(sensor, name, check(f"{name} {owner}", getattr(sensor, name)))
