"""The file `sensors.toml`, in which an engineer describes sensors: read into a `Setup`.

::

    acceleration_m_s2 = 1.0
    gate_m = 1000.0
    max_speed_m_s = 350.0
    origin = {latitude_deg = 50.0, longitude_deg = 8.5, height_m = 100.0}
    targets = "air"  # or "surface"
    target_height = {mean_m = 8000.0, sd_m = 5000.0}
    target_terms = {range_m = 20.0}

    [[sensor]]
    name = "west"
    kind = "radar2d"
    latitude_deg = 50.1
    longitude_deg = 8.1
    height_m = 250.0
    sigma_range_m = 50.0
    sigma_azimuth_deg = 0.1
    refraction = "standard"  # or "none", where the radar has corrected it
    biases = ["range", "azimuth"]
    prior_sd = {range_m = 100.0, azimuth_deg = 1.0}
    limits = {azimuth_deg = 0.1}
    drift = {azimuth_deg = "walk"}  # or "ou", "steps"
    drift_sd = {azimuth_deg = 0.1}  # prior median of the change within an hour

Units stand in the names of the keys; inside all is metres, radians and seconds. A sensor given by
latitude and longitude is level there and counts from true north; one given by `position_m` has
the axes of the common frame.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from probreg.errors import InvalidInputError
from probreg.recordings._kinds import (
    PLACE,
    by_term,
    check_names,
    drift_of,
    factor,
    flag,
    place,
    places_of,
    refuse_unknown,
    sources_of,
    target_keys,
    terms_of,
    to_sensor,
    to_table,
)
from probreg.recordings._setup import Setup
from probreg.recordings.files import replacing
from probreg.sensors import Sensor, known_kinds
from probreg.sensors.frame import LocalFrame
from probreg.validation import finite_array, positive_number

NUMBERS = ("acceleration_m_s2", "gate_m", "max_speed_m_s")
TARGETS = ("targets", "target_height", "target_terms")
FORMER = {
    "window_s": "window_s is no longer needed, since reports are compared along whole tracks: "
    "remove it from the setup file"
}
TOP = (*NUMBERS, *TARGETS, "origin", "sensor")
HEIGHT = ("mean_m", "sd_m")


def read(path: str | Path) -> Setup:
    """Read a setup file.

    Parameters
    ----------
    path : str or Path
        A TOML file as the module describes it.

    Returns
    -------
    Setup
        In a frame about the origin, or about the first sensor when places are latitudes and no
        origin is given. With places in metres and no origin there is no place on the earth.

    Raises
    ------
    InvalidInputError
        No file, no TOML, keys that are unknown or missing, values that cannot be meant.
    """
    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    except UnicodeDecodeError as error:
        raise InvalidInputError(f"{path} is not UTF-8 at byte {error.start}; save it so.") from None
    except tomllib.TOMLDecodeError as error:
        raise InvalidInputError(f"{path} is not TOML: {error}.") from None
    try:
        return parse(content)
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from None


def parse(content: Mapping[str, Any]) -> Setup:
    """Build a setup from the tables of a file; `read` says what is checked."""
    refuse_unknown({k: v for k, v in content.items() if k not in FORMER}, TOP, "the top level")
    tables = content.get("sensor")
    if not isinstance(tables, list) or not tables or not all(isinstance(t, dict) for t in tables):
        raise InvalidInputError("no sensors; give each its own [[sensor]] table.")
    for number, table in enumerate(tables, start=1):
        check_names(table, number)
    names = [table["name"] for table in tables]
    repeated = [name for k, name in enumerate(names) if name in names[:k]]
    if repeated:
        raise InvalidInputError(f"sensor {repeated[0]!r} is there twice; rename one.")
    frame = _frame(content, tables)
    surface = content.get("targets") == "surface"
    kinds = [known_kinds()[table["kind"]].kind for table in tables]
    solid = any(kind.coordinates == 3 or kind.beside is not None for kind in kinds)
    high = frame is not None or solid
    sensors = tuple(to_sensor(table, frame, 3 if high and not surface else 2) for table in tables)
    biases = {s.name: terms_of(table, s) for table, s in zip(tables, sensors, strict=True)}
    owned = list(zip(tables, sensors, strict=True))
    prior_sd, limits, drift_sd = (
        {name: sd for t, s in owned for name, sd in by_term(t, key, s, biases[s.name]).items()}
        for key in ("prior_sd", "limits", "drift_sd")
    )
    drift = {name: k for t, s in owned for name, k in drift_of(t, s, biases[s.name]).items()}
    body = frozenset(table["name"] for table in tables if flag(table, "body_frame", False))
    others: dict[str, Any] = {
        key: positive_number(key, content[key]) for key in NUMBERS if key in content
    }
    if frame is not None:
        others["origin"] = frame.latitude_deg, frame.longitude_deg, frame.height_m
    others["places"] = places_of(tables)
    others["asterix"] = sources_of(tables)
    others["refraction"] = {t["name"]: t["refraction"] for t in tables if "refraction" in t}
    others["notes"] = tuple(said for key, said in FORMER.items() if key in content)
    others |= {"drift": drift, "drift_sd": drift_sd, **_of_targets(content, sensors)}
    return Setup(sensors, biases, prior_sd, body, limits=limits, **others)


def _of_targets(content: Mapping[str, Any], sensors: Sequence[Sensor]) -> dict[str, Any]:
    """What the file says of targets."""
    found: dict[str, Any] = {"targets": content["targets"]} if "targets" in content else {}
    given = _table(content, "target_height", HEIGHT)
    if given:
        missing = [key for key in HEIGHT if key not in given]
        if missing:
            raise InvalidInputError(
                f"target_height lacks {missing[0]!r}; give {', '.join(HEIGHT)}."
            )
        found["target_height"] = tuple(
            float(finite_array(f"{key} of target_height", given[key], ())) for key in HEIGHT
        )
    known = {key: name for name, key in target_keys(sensors).items()}
    found["target_terms"] = {
        known[key]: factor(key) * positive_number(f"{key} in target_terms", value)
        for key, value in _table(content, "target_terms", tuple(known)).items()
    }
    return found


def _table(content: Mapping[str, Any], key: str, known: tuple[str, ...]) -> dict[str, Any]:
    given = content.get(key, {})
    if not isinstance(given, dict):
        raise InvalidInputError(f"{key} is {given!r}; a table of {', '.join(known)}.")
    refuse_unknown(given, known, key)
    return given


def _frame(content: Mapping[str, Any], tables: list[dict[str, Any]]) -> LocalFrame | None:
    """Frame about the origin, or about the first sensor when all are given by latitude."""
    if "origin" in content:
        return LocalFrame(*place(_table(content, "origin", PLACE), "origin"))
    global_ones = [table for table in tables if any(key in table for key in PLACE)]
    local_ones = [table["name"] for table in tables if "position_m" in table]
    if global_ones and local_ones:
        raise InvalidInputError(
            f"sensor {global_ones[0]['name']!r} is given by latitude and {local_ones[0]!r} in "
            "metres; add an origin, so that one can be put into the frame of the other."
        )
    if not global_ones:
        return None
    return LocalFrame(*place(global_ones[0], f"sensor {global_ones[0]['name']!r}"))


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + "}"
    return json.dumps(value, ensure_ascii=False)


def write(path: str | Path, setup: Setup) -> None:
    """Write a setup as a file that `read` reads; under a temporary name first.

    Raises
    ------
    InvalidInputError
        A sensor whose class has no kind in such files, or whose coordinates have errors that
        correlate; a folder that cannot be written.
    """
    strange = [s.name for s in setup.sensors if s.kind.name not in known_kinds()]
    if strange:
        known = list(known_kinds())
        raise InvalidInputError(f"sensor {strange[0]!r} is of no kind known here: {known}.")
    top: dict[str, Any] = {key: getattr(setup, key) for key in NUMBERS}
    if setup.origin is not None:
        top["origin"] = dict(zip(PLACE, setup.origin, strict=True))
    top["targets"] = setup.targets
    if setup.target_height is not None:
        top["target_height"] = dict(zip(HEIGHT, setup.target_height, strict=True))
    if setup.target_terms:
        keys = target_keys(setup.sensors)
        given = {keys[name]: tau for name, tau in setup.target_terms.items()}
        top["target_terms"] = {key: tau / factor(key) for key, tau in given.items()}
    lines = [f"{key} = {_toml(value)}" for key, value in top.items()]
    for sensor in setup.sensors:
        lines += ["", "[[sensor]]"]
        lines += [f"{key} = {_toml(value)}" for key, value in to_table(setup, sensor).items()]
    with replacing(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
