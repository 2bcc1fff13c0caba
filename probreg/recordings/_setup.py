"""What the engineer knows of the sensors and wants estimated: the content of `sensors.toml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from probreg.errors import InvalidInputError
from probreg.sensors import Sensor
from probreg.validation import finite_array, positive_number


@dataclass(frozen=True, eq=False)
class Setup:
    """Sensors, the biases to estimate, and how targets move.

    Parameters
    ----------
    sensors : tuple of Sensor
    biases : mapping of str to tuple of str
        For each sensor's name the bias terms to estimate; none for a reference.
    prior_sd : mapping of str to float
        Prior standard deviation of biases by name ("west.range"), SI units; others take
        the sensor's own default.
    body_frame : frozenset of str
        Sensors whose azimuth counts from the platform's heading.
    acceleration_m_s2 : float
        Standard deviation of the targets' acceleration over one second: how far a target may
        leave a straight line between its reports.
    window_s : float
        Longest time between reports that are compared.
    gate_m : float
        Largest distance at which reports are taken for one target.
    max_speed_m_s : float
        Of any target: reports that one could only reach faster are not of it.
    limits : mapping of str to float
        Largest absolute bias that is acceptable, by name, SI units.
    origin : tuple of float, optional
        Latitude and longitude in degrees and height in metres of the common frame's origin.
    heights_m : mapping of str to float
        Of two-dimensional radars by name, above the ellipsoid, or above the plane of a frame
        without an origin: for slant ranges of targets whose height is reported.
    asterix : mapping of (int, int) to str
        From area and identification code of a source of ASTERIX messages to the sensor's name.

    Raises
    ------
    InvalidInputError
        Names of sensors that are not there, numbers that are not positive.
    """

    sensors: tuple[Sensor, ...]
    biases: Mapping[str, tuple[str, ...]]
    prior_sd: Mapping[str, float] = field(default_factory=dict)
    body_frame: frozenset[str] = frozenset()
    acceleration_m_s2: float = 1.0
    window_s: float = 10.0
    gate_m: float = 1_000.0
    max_speed_m_s: float = 350.0
    limits: Mapping[str, float] = field(default_factory=dict)
    origin: tuple[float, float, float] | None = None
    heights_m: Mapping[str, float] = field(default_factory=dict)
    asterix: Mapping[tuple[int, int], str] = field(default_factory=dict)
    target_height: tuple[float, float] | None = None
    target_terms: Mapping[str, float] = field(default_factory=dict)

    @property
    def dim(self) -> int:
        """Coordinates of the common frame."""
        return max(sensor.dim for sensor in self.sensors)

    def __post_init__(self) -> None:
        names = {sensor.name for sensor in self.sensors}
        used = {*self.biases, *self.body_frame, *self.heights_m, *self.asterix.values()}
        strange = used - names
        if strange:
            raise InvalidInputError(f"{sorted(strange)} are no sensors; known: {sorted(names)}.")
        for name in ("acceleration_m_s2", "window_s", "gate_m", "max_speed_m_s"):
            positive_number(name, getattr(self, name))
        for kind, numbers in (("prior_sd", self.prior_sd), ("limits", self.limits)):
            for name, value in numbers.items():
                positive_number(f"{kind} of {name}", value)
        for name, value in self.heights_m.items():
            finite_array(f"height of {name}", value, ())
