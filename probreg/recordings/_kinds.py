"""Kinds of sensors in `sensors.toml`: the keys of each, into a sensor and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._setup import Setup
from probreg.recordings._slant import raised
from probreg.recordings.local_frame import LocalFrame
from probreg.sensors import BearingSensor, PositionSensor, Radar2D, Radar3D, Sensor
from probreg.validation import finite_array, positive_number

UNITS = {"_m": 1.0, "_deg": float(np.deg2rad(1.0)), "_s": 1.0}
PLACE = ("latitude_deg", "longitude_deg", "height_m")
COMMON = ("name", "kind", "reference", "biases", "prior_sd", "limits")
TERM_UNITS = {"m": "_m", "rad": "_deg"}
OTHER_TERM_UNITS = {"time": "_s", "heading": "_deg"}


@dataclass(frozen=True)
class Kind:
    """What a kind of sensor is made of.

    Attributes
    ----------
    make : type
        The sensor's class.
    sigmas : dict of str to str
        From the key in the file to the parameter of the class.
    coordinates : int
        Of its own position; 0 where it has none.
    angles : bool
        Whether it measures angles, and so has `from_north` and `body_frame`.
    """

    make: type
    sigmas: Mapping[str, str]
    coordinates: int
    angles: bool

    @property
    def keys(self) -> tuple[str, ...]:
        """Every key that a sensor of this kind may have."""
        place = ("position_m", *PLACE) if self.coordinates else ()
        angles = ("from_north", "body_frame") if self.angles else ()
        return (*COMMON, *self.sigmas, *place, *angles)


_RADAR = {"sigma_range_m": "sigma_range", "sigma_azimuth_deg": "sigma_azimuth"}
KINDS = {
    "radar2d": Kind(Radar2D, _RADAR, 2, True),
    "radar3d": Kind(Radar3D, {**_RADAR, "sigma_elevation_deg": "sigma_elevation"}, 3, True),
    "position": Kind(PositionSensor, {"sigma_m": "noise_covariance"}, 0, False),
    "bearing": Kind(BearingSensor, {"sigma_azimuth_deg": "sigma_bearing"}, 0, True),
}


def refuse_unknown(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    strange = [key for key in table if key not in known]
    if strange:
        raise InvalidInputError(
            f"unknown key {strange[0]!r} in {where}; known: {', '.join(known)}."
        )


def check_names(table: Mapping[str, Any], number: int) -> None:
    name, kind = table.get("name"), table.get("kind")
    if not isinstance(name, str) or not name or "." in name:
        raise InvalidInputError(f"sensor {number} needs a name without dots, not {name!r}.")
    if kind not in KINDS:
        known = ", ".join(KINDS)
        raise InvalidInputError(f"kind of sensor {name!r} is {kind!r}; known: {known}.")
    refuse_unknown(table, KINDS[kind].keys, f"sensor {name!r} ({kind})")
    if "position_m" in table and any(key in table for key in PLACE):
        raise InvalidInputError(f"sensor {name!r} has position_m and a latitude; keep one.")


def flag(table: Mapping[str, Any], key: str, default: bool) -> bool:
    value = table.get(key, default)
    if not isinstance(value, bool):
        raise InvalidInputError(f"{key} of sensor {table['name']!r} is {value!r}; true or false.")
    return value


def place(table: Mapping[str, Any], owner: str) -> tuple[float, float, float]:
    missing = [key for key in PLACE if key not in table]
    if missing:
        raise InvalidInputError(f"{owner} lacks {missing[0]!r}; give {', '.join(PLACE)}.")
    numbers = finite_array(f"place of {owner}", [table[key] for key in PLACE], (3,))
    latitude, longitude, height = numbers.tolist()
    return latitude, longitude, height


def _position(table: Mapping[str, Any], frame: LocalFrame | None, count: int) -> tuple[float, ...]:
    owner = f"sensor {table['name']!r}"
    if "position_m" in table:
        position = finite_array(f"position_m of {owner}", table["position_m"], (None,))
        if len(position) not in (count, 3):
            raise InvalidInputError(
                f"position_m of {owner} has {len(position)} numbers; give [east, north, up]."
            )
        return tuple(position[:count].tolist())
    if frame is None:
        raise InvalidInputError(f"{owner} lacks position_m (or {', '.join(PLACE)}).")
    local = frame.from_geodetic(np.asarray(place(table, owner)))
    return tuple(local[:count].tolist())


def height_of(table: Mapping[str, Any], frame: LocalFrame | None) -> float | None:
    """Height of a two-dimensional radar, which its sensor does not keep; None if not given."""
    if KINDS[table["kind"]].coordinates != 2:
        return None
    if "position_m" not in table:
        return place(table, f"sensor {table['name']!r}")[2]
    position = np.asarray(table["position_m"], dtype=float)
    if len(position) < 3:
        return None
    return float(position[2] if frame is None else frame.to_geodetic(position)[2])


def _number(table: Mapping[str, Any], key: str) -> float:
    """Take one number of the file, in SI units by the ending of its key."""
    owner = f"{key} of sensor {table['name']!r}"
    if key not in table:
        raise InvalidInputError(f"sensor {table['name']!r} lacks {key!r}; add its accuracy.")
    factor = UNITS["_" + key.rsplit("_", 1)[1]]
    return factor * positive_number(owner, table[key])


def _covariance(table: Mapping[str, Any], dim: int) -> tuple[tuple[float, ...], ...]:
    """Covariance from `sigma_m`: one number for all axes, or one an axis."""
    given = table.get("sigma_m")
    if isinstance(given, list):
        sigma = finite_array(f"sigma_m of sensor {table['name']!r}", given, (None,))
    else:
        sigma = np.full(dim, _number(table, "sigma_m"))
    return tuple(tuple(row) for row in np.diag(sigma**2).tolist())


def to_sensor(table: Mapping[str, Any], frame: LocalFrame | None, dim: int) -> Sensor:
    kind = KINDS[table["kind"]]
    parts: dict[str, Any] = {"name": table["name"]}
    for key, parameter in kind.sigmas.items():
        parts[parameter] = _covariance(table, dim) if key == "sigma_m" else _number(table, key)
    if kind.coordinates:
        parts["position"] = _position(table, frame, kind.coordinates)
    if kind.angles:
        parts["from_north"] = flag(table, "from_north", True)
    made: Sensor = kind.make(**parts)
    return made


def terms_of(table: Mapping[str, Any], sensor: Sensor) -> tuple[str, ...]:
    """Terms to estimate: those named, none of a reference, else every report component."""
    reference = flag(table, "reference", False)
    terms = table.get("biases", [] if reference else list(sensor.bias_names))
    if not isinstance(terms, list) or not all(isinstance(term, str) for term in terms):
        raise InvalidInputError(f"biases of sensor {sensor.name!r} must be a list of names.")
    if reference and terms:
        raise InvalidInputError(
            f"sensor {sensor.name!r} is a reference and has biases {terms}; drop one of the two."
        )
    if len(set(terms)) < len(terms):
        raise InvalidInputError(f"biases of sensor {sensor.name!r} repeat: {terms}.")
    return tuple(terms)


def by_term(
    table: Mapping[str, Any], key: str, sensor: Sensor, terms: tuple[str, ...]
) -> dict[str, float]:
    """Numbers by bias name in SI units, from keys such as "azimuth_deg"; a gain has no unit."""
    given, where = table.get(key, {}), f"{key} of sensor {sensor.name!r}"
    if not isinstance(given, dict):
        raise InvalidInputError(f"{where} is {given!r}; a table such as {{range_m = 100}}.")
    endings = {term: _ending(term, sensor) for term in terms}
    known = {term + ending: term for term, ending in endings.items()}
    refuse_unknown(given, tuple(known), f"{where} (one for each of its biases)")
    return {
        f"{sensor.name}.{known[name]}": UNITS.get(endings[known[name]], 1.0)
        * positive_number(f"{name} in {where}", value)
        for name, value in given.items()
    }


def _ending(term: str, sensor: Sensor) -> str:
    """Unit that a term's key must end with: that of the component its first word names."""
    if term.endswith("_gain"):
        return ""
    of_components = dict(zip(sensor.bias_names, sensor.bias_units, strict=True))
    word = term.split("_", 1)[0]
    unit = of_components.get(term, of_components.get(word))
    return TERM_UNITS[unit] if unit else OTHER_TERM_UNITS.get(word, "")


def _up(setup: Setup, sensor: Sensor) -> tuple[float, ...]:
    """Third coordinate of a two-dimensional radar whose height is known."""
    height = setup.heights_m.get(sensor.name)
    if height is None or setup.origin is None:
        return () if height is None else (height,)
    frame, plane = LocalFrame(*setup.origin), np.asarray(sensor.position)  # type: ignore[attr-defined]
    return (float(frame.from_geodetic(raised(frame, plane, np.array(height)))[2]),)


def to_table(setup: Setup, sensor: Sensor) -> dict[str, Any]:
    """Turn a sensor back into what the file says of it."""
    kind_name = next(name for name, kind in KINDS.items() if type(sensor) is kind.make)
    kind = KINDS[kind_name]
    table: dict[str, Any] = {"name": sensor.name, "kind": kind_name}
    for key, parameter in kind.sigmas.items():
        value = getattr(sensor, parameter)
        if key == "sigma_m":
            sigma = np.sqrt(np.diag(value))
            if not np.array_equal(value, np.diag(np.diag(value))):
                raise InvalidInputError(f"errors of sensor {sensor.name!r} must not correlate.")
            table[key] = sigma.tolist()
        else:
            table[key] = value / UNITS["_" + key.rsplit("_", 1)[1]]
    if kind.coordinates:
        table["position_m"] = [*sensor.position, *_up(setup, sensor)]  # type: ignore[attr-defined]
    if kind.angles:
        table["from_north"] = sensor.from_north  # type: ignore[attr-defined]
        table["body_frame"] = sensor.name in setup.body_frame
    terms = setup.biases.get(sensor.name, ())
    table["biases" if terms else "reference"] = list(terms) or True
    for key, numbers in (("prior_sd", setup.prior_sd), ("limits", setup.limits)):
        given = {}
        for term in terms:
            if f"{sensor.name}.{term}" in numbers:
                ending = _ending(term, sensor)
                given[term + ending] = numbers[f"{sensor.name}.{term}"] / UNITS.get(ending, 1.0)
        if given:
            table[key] = given
    return table
