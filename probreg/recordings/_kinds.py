"""Kinds of sensors in `sensors.toml`: the keys of each, into a sensor and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings._setup import Setup
from probreg.sensors import Barometer, Sensor, known_kinds
from probreg.sensors.drifts import known_drifts
from probreg.sensors.frame import LocalFrame
from probreg.sensors.terms import known_terms
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_number

PLACE = ("latitude_deg", "longitude_deg", "height_m")
DRIFT = ("drift", "drift_sd")
COMMON = ("name", "kind", "reference", "biases", "prior_sd", "limits", "asterix", *DRIFT)
ENDINGS = {"m": "_m", "rad": "_deg", "s": "_s"}  # of a key, by the unit of a bias term


def factor(key: str) -> float:
    """SI units a unit of a key or column, by the ending of its name or as its kind has it."""
    if key.endswith("_deg"):
        return float(np.deg2rad(1.0))
    return next(
        (owner.kind.others[key] for owner in known_kinds().values() if key in owner.kind.others),
        1.0,
    )


def keys_of(owner: type[Sensor]) -> tuple[str, ...]:
    """Every key that a sensor of a class may have."""
    kind = owner.kind
    place = ("position_m", *PLACE, "refraction") if kind.coordinates else ()
    angles = () if owner.azimuth_column is None else ("from_north", "body_frame")
    return (*COMMON, *kind.sigmas, *place, *angles)


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
    owner = known_kinds().get(kind) if isinstance(kind, str) else None
    if owner is None:
        known = ", ".join(known_kinds())
        raise InvalidInputError(f"kind of sensor {name!r} is {kind!r}; known: {known}.")
    refuse_unknown(table, keys_of(owner), f"sensor {name!r} ({kind})")
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
        return tuple(position.tolist())
    if frame is None:
        raise InvalidInputError(f"{owner} lacks position_m (or {', '.join(PLACE)}).")
    return tuple(frame.from_geodetic(np.asarray(place(table, owner))).tolist())


def places_of(tables: Sequence[Mapping[str, Any]]) -> dict[str, tuple[float, float, float]]:
    """Places of the sensors that are given on the earth."""
    given = [table for table in tables if any(key in table for key in PLACE)]
    return {table["name"]: place(table, f"sensor {table['name']!r}") for table in given}


def _number(table: Mapping[str, Any], key: str) -> float:
    """Take one number of the file, in SI units by the ending of its key."""
    owner = f"{key} of sensor {table['name']!r}"
    if key not in table:
        raise InvalidInputError(f"sensor {table['name']!r} lacks {key!r}; add its accuracy.")
    return factor(key) * positive_number(owner, table[key])


def _per_axis(table: Mapping[str, Any], key: str, dim: int) -> FloatArray:
    """One number for all axes, or one an axis."""
    given = table.get(key)
    if isinstance(given, list):
        return finite_array(f"{key} of sensor {table['name']!r}", given, (None,))
    return np.full(dim, _number(table, key))


def sources_of(tables: Sequence[Mapping[str, Any]]) -> dict[tuple[int, int], str]:
    """Names of sensors by the area and identification code of their ASTERIX messages."""
    found: dict[tuple[int, int], str] = {}
    for table in tables:
        given, name = table.get("asterix"), table["name"]
        if given is None:
            continue
        codes = given if isinstance(given, list) else []
        if len(codes) != 2 or not all(type(c) is int and 0 <= c <= 255 for c in codes):
            raise InvalidInputError(
                f"asterix of sensor {name!r} is {given!r}; two whole numbers from 0 to 255, "
                "[SAC, SIC]."
            )
        other = found.setdefault((codes[0], codes[1]), name)
        if other != name:
            raise InvalidInputError(
                f"sensors {other!r} and {name!r} have the same asterix = {given}; correct one."
            )
    return found


def to_sensor(table: Mapping[str, Any], frame: LocalFrame | None, dim: int) -> Sensor:
    owner = known_kinds()[table["kind"]]
    kind, others = owner.kind, {"name": table["name"]}
    sigmas = {
        key: _per_axis(table, key, dim) if kind.per_axis else _number(table, key)
        for key in kind.sigmas
    }
    if kind.coordinates:
        others["position"] = _position(table, frame, kind.coordinates)
    if owner.azimuth_column is not None:
        others["from_north"] = flag(table, "from_north", True)
    made: Sensor = kind.make(owner, sigmas, **others)
    return made


def default_terms(sensor: Sensor) -> tuple[str, ...]:
    """Terms to estimate unless the setup says otherwise."""
    return sensor.bias_names if sensor.kind.terms is None else sensor.kind.terms


def terms_of(table: Mapping[str, Any], sensor: Sensor) -> tuple[str, ...]:
    """Terms to estimate: those named, none of a reference, else what is usual for the kind."""
    reference = flag(table, "reference", False)
    usual = default_terms(sensor)
    terms = table.get("biases", [] if reference else list(usual))
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
    where = f"{key} of sensor {sensor.name!r}"
    return {
        full: factor(name) * positive_number(f"{name} in {where}", value)
        for full, (name, value) in _given(table, key, sensor, terms).items()
    }


def drift_of(table: Mapping[str, Any], sensor: Sensor, terms: tuple[str, ...]) -> dict[str, str]:
    """How biases drift, by name, from keys such as "azimuth_deg"."""
    found = _given(table, "drift", sensor, terms)
    for name, kind in found.values():
        if not isinstance(kind, str) or kind not in known_drifts():
            raise InvalidInputError(
                f"drift of sensor {sensor.name!r}: {name} is {kind!r}; it can be "
                f"{', '.join(sorted(known_drifts()))}."
            )
    return {full: kind for full, (_, kind) in found.items()}


def _given(
    table: Mapping[str, Any], key: str, sensor: Sensor, terms: tuple[str, ...]
) -> dict[str, tuple[str, Any]]:
    """Keys and values of a table by bias, by the bias's full name."""
    given, where = table.get(key, {}), f"{key} of sensor {sensor.name!r}"
    if not isinstance(given, dict):
        raise InvalidInputError(f"{where} is {given!r}; a table such as {{range_m = 100}}.")
    endings = {term: _ending(term, sensor) for term in terms}
    known = {term + ending: term for term, ending in endings.items()}
    refuse_unknown(given, tuple(known), f"{where} (one for each of its biases)")
    return {f"{sensor.name}.{known[name]}": (name, value) for name, value in given.items()}


def _ending(term: str, sensor: Sensor) -> str:
    """Unit that a term's key must end with; none of a gain, and of what the sensor cannot have."""
    known = known_terms(sensor)
    return ENDINGS.get(known[term].unit, "") if term in known else ""


def target_keys(sensors: Sequence[Sensor]) -> dict[str, str]:
    """Keys of `target_terms`, with the unit at the end, by name of the term."""
    owners = (*sensors, Barometer(1.0))  # which readers of heights add
    return {name: name + _ending(name, sensor) for sensor in owners for name in known_terms(sensor)}


def to_table(setup: Setup, sensor: Sensor) -> dict[str, Any]:
    """Turn a sensor back into what the file says of it.

    Raises
    ------
    InvalidInputError
        Errors that correlate.
    """
    table: dict[str, Any] = {"name": sensor.name, "kind": sensor.kind.name}
    for key, value in sensor.kind.sigmas_of(sensor).items():
        table[key] = value if sensor.kind.per_axis else value / factor(key)
    if sensor.name in setup.places:
        table |= zip(PLACE, setup.places[sensor.name], strict=True)
    elif sensor.position is not None:
        table["position_m"] = list(sensor.position)
    if sensor.name in setup.refraction:
        table["refraction"] = setup.refraction[sensor.name]
    if sensor.azimuth_column is not None:
        table["from_north"] = sensor.from_north
        table["body_frame"] = sensor.name in setup.body_frame
    source = next((code for code, name in setup.asterix.items() if name == sensor.name), None)
    if source is not None:
        table["asterix"] = list(source)
    terms = setup.biases.get(sensor.name, ())
    table["biases" if terms else "reference"] = list(terms) or True
    named = {term: f"{sensor.name}.{term}" for term in terms}
    drift = {term + _ending(term, sensor): setup.drift[full]
             for term, full in named.items() if full in setup.drift}  # fmt: skip
    if drift:
        table["drift"] = drift
    by_name = {"prior_sd": setup.prior_sd, "limits": setup.limits, "drift_sd": setup.drift_sd}
    for key, numbers in by_name.items():
        given = {}
        for term in terms:
            if f"{sensor.name}.{term}" in numbers:
                name = term + _ending(term, sensor)
                given[name] = numbers[f"{sensor.name}.{term}"] / factor(name)
        if given:
            table[key] = given
    return table
