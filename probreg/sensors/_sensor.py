"""What every sensor offers, and what most kinds share."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from probreg.sensors._kind import Kind
from probreg.sensors.axes import Axes, Site
from probreg.typing import FloatArray
from probreg.validation import angle_sigma, finite_array, positive_number


class Equations(NamedTuple):
    """What n reports say of where their targets are: e = G x + D bias + noise of covariance C.

    Shapes (n, d), (n, d, d), (n, d, d) and (n, d, q). A kind whose reports give fewer than d
    equations leaves the last ones zero.
    """

    e: FloatArray
    G: FloatArray
    C: FloatArray
    D: FloatArray


class Sensor(Protocol):
    """What a recording and its registration ask of a sensor.

    A report has q = `len(bias_names)` components, and a bias adds to each of them:
    report = truth + bias + noise. Positions are of d = `dim` coordinates in the common frame;
    a frame of three takes sensors of two as well, through `axes`.
    `own`, shape (n, d), is where the platform of a moving sensor is at each report: the sensor
    sees from there, and its own place, where it has one, is relative to it.

    Attributes
    ----------
    kind : Kind
        What files say of sensors of this class.
    azimuth_column : int or None
        Which report component is an azimuth; None for a kind without.
    gives_position : bool
        Whether a single report places its target.
    cartesian : bool
        Whether reports are positions themselves, so that the equations are linear.
    """

    kind: ClassVar[Kind]
    azimuth_column: ClassVar[int | None]
    gives_position: ClassVar[bool]
    cartesian: ClassVar[bool]

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

    @property
    def position(self) -> tuple[float, ...] | None:
        """Its own place, `dim` coordinates or three, metres; None for a kind without."""

    @property
    def from_north(self) -> bool:
        """Whether the azimuth counts from y (north), clockwise; else from x, counter-clockwise."""

    @property
    def sigmas(self) -> FloatArray:
        """Accuracy of each component (q,), as declared: in the SI unit of its `kind.sigma_key`."""

    @property
    def principal(self) -> tuple[FloatArray, FloatArray | None]:
        """Accuracies (q,) of errors that are independent, and the rotation (q, q) into these.

        None for the rotation where the errors of the components are independent.
        """

    def check(self, reports: FloatArray) -> FloatArray:
        """Return reports, shape (n, q), after checking them.

        NaN passes where a component may be missing, such as the height of a position.
        """

    def to_cartesian(
        self, reports: FloatArray, own: FloatArray | None = None, *, unbiased: bool = True
    ) -> FloatArray:
        """Convert reports (n, q) to positions (n, d); NaN where one report places no target."""

    def to_report(self, positions: FloatArray, own: FloatArray | None = None) -> FloatArray:
        """Convert positions (n, d) to noise-free reports (n, q)."""

    def axes(self, site: Site) -> Axes:
        """Its reports in their own axes, of targets in the common frame of a site.

        Own positions of a moving platform are taken from the targets' first.
        """

    def observe(
        self, reports: FloatArray, at: FloatArray | None = None, own: FloatArray | None = None
    ) -> Equations:
        """Equations of reports (n, q), linearised about targets at (n, d).

        Without `at` they are linearised where the reports themselves put the targets; reports
        that put them nowhere give no equation then.
        """

    def report_sd(self, reports: FloatArray) -> FloatArray:
        """Standard deviations (n, q) of the components of reports (n, q), metres and radians."""

    def sample_noise(
        self, rng: np.random.Generator, n: int, at: FloatArray | None = None
    ) -> FloatArray:
        """Draw n errors of reports, shape (n, q).

        Kinds whose errors depend on where the target is, relative to the platform, need `at`,
        shape (n, d).
        """


class PlacingSensor(Sensor, Protocol):
    """A sensor whose single reports place their targets: positions can be compared directly."""

    def sensitivity(self, positions: FloatArray) -> FloatArray:
        """Derivative (n, d, q) of the converted position with respect to the bias."""

    def covariance(self, positions: FloatArray) -> FloatArray:
        """Covariance (n, d, d) of the converted position."""


def observe_position(
    sensor: PlacingSensor, reports: FloatArray, at: FloatArray | None, own: FloatArray | None
) -> Equations:
    """Equations of reports that are converted to positions; see `Sensor.observe`."""
    local = sensor.to_cartesian(reports)
    where = local if at is None else relative(at, own)
    G = np.broadcast_to(np.eye(sensor.dim), (len(reports), sensor.dim, sensor.dim))
    e = local if own is None else local + own
    return Equations(e, G, sensor.covariance(where), sensor.sensitivity(where))


def relative(positions: FloatArray, own: FloatArray | None) -> FloatArray:
    """Positions as seen from the platform."""
    return positions if own is None else positions - own


def settle(sensor: Any, dim: int, *sigmas: str) -> None:
    """Check a radar's numbers and store them as floats, so that equal sensors compare equal."""
    owner = f"of sensor {sensor.name!r}"
    high = dim == 2 and np.shape(sensor.position) == (3,)
    position = finite_array(f"position {owner}", sensor.position, (3 if high else dim,))
    object.__setattr__(sensor, "position", tuple(position.tolist()))
    for name in sigmas:
        check = positive_number if name == "sigma_range" else angle_sigma
        object.__setattr__(sensor, name, check(f"{name} {owner}", getattr(sensor, name)))
