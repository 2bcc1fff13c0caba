"""What the engineer knows of the sensors and wants estimated: the content of `sensors.toml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from probreg.errors import InvalidInputError
from probreg.sensors import Barometer, Sensor
from probreg.sensors.drifts import known_drifts
from probreg.sensors.terms import known_terms
from probreg.validation import finite_array, positive_number

TARGETS = ("air", "surface")
REFRACTION = ("standard", "none")
LOWEST_M, HIGHEST_M = -500.0, 9_000.0  # of the ground, and what stands on it
FARTHEST_UP_M = 100_000.0  # of aircraft


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
        Standard deviation of the targets' acceleration over one second, white noise: a first
        guess, the density is estimated with its square as the prior median.
    gate_m : float
        Largest distance at which reports are taken for one target.
    max_speed_m_s : float
        Of any target: reports that one could only reach faster are not of it.
    limits : mapping of str to float
        Largest absolute bias that is acceptable, by name, SI units.
    origin : tuple of float, optional
        Latitude and longitude in degrees and height in metres of the common frame's origin.
    asterix : mapping of (int, int) to str
        From area and identification code of a source of ASTERIX messages to the sensor's name.
    places : mapping of str to tuple of float
        Latitude, longitude (degrees) and height (metres above the ellipsoid) of sensors that
        are given on the earth: they are level there and count from true north. Others have the
        axes of the common frame.
    targets : str
        "air", or "surface" for ships and vehicles, which stay in the plane of the frame.
    target_height : tuple of float, optional
        Mean and standard deviation, metres, of the heights of targets none of whose reports
        tells a height.
    target_terms : mapping of str to float
        Terms of which each target has a constant of its own, with their prior spread, SI units.
    refraction : mapping of str to str
        By sensor "standard" or "none", where its processor has corrected it. By default
        standard for sensors of ranges that are given on the earth.
    geodetic : frozenset of str
        Position sensors that report latitude and longitude. Readers of recordings fill it in.
    notes : tuple of str
        What the reader of results should know of the setup.
    drift : mapping of str to str
        Biases that drift, by name, and how: a name of `known_drifts`.
    drift_sd : mapping of str to float
        Prior median of how far they move, SI units, as `Drift.meaning` says; by default a tenth
        of the prior standard deviation.

    Raises
    ------
    InvalidInputError
        Names of sensors that are not there, numbers that cannot be, three-dimensional sensors
        of targets on the surface.
    """

    sensors: tuple[Sensor, ...]
    biases: Mapping[str, tuple[str, ...]]
    prior_sd: Mapping[str, float] = field(default_factory=dict)
    body_frame: frozenset[str] = frozenset()
    acceleration_m_s2: float = 1.0
    gate_m: float = 1_000.0
    max_speed_m_s: float = 350.0
    limits: Mapping[str, float] = field(default_factory=dict)
    origin: tuple[float, float, float] | None = None
    asterix: Mapping[tuple[int, int], str] = field(default_factory=dict)
    places: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    targets: str = "air"
    target_height: tuple[float, float] | None = None
    target_terms: Mapping[str, float] = field(default_factory=dict)
    refraction: Mapping[str, str] = field(default_factory=dict)
    geodetic: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
    drift: Mapping[str, str] = field(default_factory=dict)
    drift_sd: Mapping[str, float] = field(default_factory=dict)

    @property
    def dim(self) -> int:
        """Coordinates of the common frame: three of targets in the air, where any is known."""
        high = self.origin is not None or any(sensor.dim == 3 for sensor in self.sensors)
        return 3 if high and self.targets == "air" else 2

    def refracted(self, sensor: Sensor) -> bool:
        """Whether a sensor's reports are those of rays bent by the atmosphere."""
        if self.dim == 2 or self.origin is None or "range" not in sensor.bias_names:
            return False
        given = self.refraction.get(sensor.name)
        return sensor.name in self.places if given is None else given == "standard"

    def __post_init__(self) -> None:
        names = {sensor.name for sensor in self.sensors}
        used = {*self.biases, *self.body_frame, *self.asterix.values(), *self.places}
        strange = {*used, *self.refraction, *self.geodetic} - names
        if strange:
            raise InvalidInputError(f"{sorted(strange)} are no sensors; known: {sorted(names)}.")
        for name in ("acceleration_m_s2", "gate_m", "max_speed_m_s"):
            positive_number(name, getattr(self, name))
        numbers = {"prior_sd": self.prior_sd, "limits": self.limits, "drift_sd": self.drift_sd}
        for kind, given in {**numbers, "target_terms": self.target_terms}.items():
            for name, value in given.items():
                positive_number(f"{kind} of {name}", value)
        self._check_drift()
        self._check_earth()
        self._check_targets()

    def _check_drift(self) -> None:
        known = known_drifts()
        for name, kind in self.drift.items():
            if kind not in known:
                raise InvalidInputError(
                    f"drift of {name} is {kind!r}; it can be {', '.join(sorted(known))}."
                )
        strange = sorted(set(self.drift_sd) - set(self.drift))
        if strange:
            raise InvalidInputError(f"drift_sd names {strange[0]}, which drift does not.")

    def _check_earth(self) -> None:
        if self.places and self.origin is None:
            raise InvalidInputError(
                f"sensor {next(iter(self.places))!r} has a latitude, and the setup no origin."
            )
        places = {f"sensor {name!r}": place for name, place in self.places.items()}
        if self.origin is not None:
            places["the origin"] = self.origin
        for owner, place in places.items():
            height = finite_array(f"place of {owner}", place, (3,))[2]
            if not LOWEST_M <= height <= HIGHEST_M:
                raise InvalidInputError(
                    f"height_m of {owner} is {height:g}: that is "
                    f"{'inside' if height < 0.0 else 'far above'} the earth. Give metres above "
                    f"the ellipsoid, from {LOWEST_M:g} to {HIGHEST_M:g}."
                )
        for name, given in self.refraction.items():
            if given not in REFRACTION:
                raise InvalidInputError(
                    f"refraction of sensor {name!r} is {given!r}; one of {REFRACTION}."
                )
            if given == "standard" and self.origin is None:
                raise InvalidInputError(
                    f"refraction of sensor {name!r} needs a place on the earth; give an origin."
                )

    def _check_targets(self) -> None:
        if self.targets not in TARGETS:
            raise InvalidInputError(f"targets are {self.targets!r}; one of {TARGETS}.")
        high = [s.name for s in self.sensors if s.dim == 3]
        if self.targets == "surface" and high:
            raise InvalidInputError(
                f"sensor {high[0]!r} tells heights, and targets are on the surface, which has "
                'none. Take a sensor of two dimensions, or set targets = "air".'
            )
        if self.target_height is not None:
            mean, sd = self.target_height
            finite_array("mean of target_height", mean, ())
            positive_number("sd of target_height", sd)
            if not LOWEST_M <= mean <= FARTHEST_UP_M:
                raise InvalidInputError(
                    f"the mean of target_height is {mean:g} m; give metres above the ellipsoid."
                )
        owners = (*self.sensors, Barometer(1.0))
        own = {t.name for s in owners for t in known_terms(s).values() if t.owner == s.name}
        strange = sorted(set(self.target_terms) - own)
        if strange:
            raise InvalidInputError(
                f"target_terms has {strange[0]!r}; targets can have {', '.join(sorted(own))}."
            )
