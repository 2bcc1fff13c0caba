"""What sensors that report heights share."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from probreg.sensors._kind import Kind
from probreg.sensors._sensor import Equations, relative
from probreg.sensors.axes import HeightAxes, Site
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_number


class HeightSensor:
    """What sensors of heights share; fields live in the subclasses."""

    sigma_height: float
    name: str
    kind: ClassVar[Kind]

    dim: ClassVar[int] = 3
    bias_names: ClassVar[tuple[str, ...]] = ("height",)
    bias_units: ClassVar[tuple[str, ...]] = ("m",)
    position: ClassVar[None] = None
    azimuth_column: ClassVar[int | None] = None
    from_north: ClassVar[bool] = False
    gives_position: ClassVar[bool] = False
    cartesian: ClassVar[bool] = False

    def __post_init__(self) -> None:
        sigma = positive_number(f"sigma_height of sensor {self.name!r}", self.sigma_height)
        object.__setattr__(self, "sigma_height", sigma)

    @property
    def principal(self) -> tuple[FloatArray, None]:
        """Accuracies of the components, whose errors are independent."""
        return self.sigmas, None

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviation of a height (1,), metres."""
        return np.array([self.sigma_height])

    def check(self, reports: FloatArray) -> FloatArray:
        """Check heights (n, 1) for shape and non-finite values."""
        return finite_array(f"heights of sensor {self.name!r}", reports, (None, 1))

    def to_cartesian(
        self, reports: FloatArray, own: FloatArray | None = None, *, unbiased: bool = True
    ) -> FloatArray:
        """NaN (n, 3): a height alone places no target."""
        return np.full((len(reports), self.dim), np.nan)

    def to_report(self, positions: FloatArray, own: FloatArray | None = None) -> FloatArray:
        """Third coordinates (n, 1) of positions (n, 3): the heights above a flat earth."""
        return relative(np.asarray(positions, dtype=float), own)[:, 2:]

    def axes(self, site: Site) -> HeightAxes:
        """Height above the ellipsoid, or above the plane of a frame without an origin."""
        if site.frame is None:
            return HeightAxes()
        return HeightAxes(float(np.deg2rad(site.frame.latitude_deg)), site.frame.height_m)

    def observe(
        self, reports: FloatArray, at: FloatArray | None = None, own: FloatArray | None = None
    ) -> Equations:
        """One equation a report, of the third coordinate; none without `at`."""
        n, d = len(reports), self.dim
        e, G, C, D = np.zeros((n, d)), np.zeros((n, d, d)), np.zeros((n, d, d)), np.zeros((n, d, 1))
        if at is not None:
            e[:, 0] = reports[:, 0] + (0.0 if own is None else own[:, 2])
            G[:, 0, 2] = D[:, 0, 0] = 1.0
            C[:, 0, 0] = self.sigma_height**2
        return Equations(e, G, C, D)

    def report_sd(self, reports: FloatArray) -> FloatArray:
        """Standard deviations (n, 1), the same for every report."""
        return np.broadcast_to(self.sigmas, np.shape(reports))

    def sample_noise(
        self, rng: np.random.Generator, n: int, at: FloatArray | None = None
    ) -> FloatArray:
        """Draw n Gaussian errors of heights, shape (n, 1), wherever the targets are."""
        return self.sigma_height * rng.standard_normal((n, 1))
