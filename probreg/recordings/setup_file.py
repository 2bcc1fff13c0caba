"""The file `sensors.toml`, in which an engineer describes sensors: read into a `Setup`.

::

    acceleration_m_s2 = 1.0
    window_s = 10.0
    gate_m = 1000.0
    max_speed_m_s = 350.0
    origin = {latitude_deg = 50.0, longitude_deg = 8.5, height_m = 100.0}

    [[sensor]]
    name = "west"
    kind = "radar2d"
    latitude_deg = 50.1
    longitude_deg = 8.1
    height_m = 250.0
    sigma_range_m = 50.0
    sigma_azimuth_deg = 0.1
    biases = ["range", "azimuth"]
    prior_sd = {range_m = 100.0, azimuth_deg = 1.0}
    limits = {azimuth_deg = 0.1}

Units stand in the names of the keys; inside all is metres, radians and seconds.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from probreg.errors import InvalidInputError
from probreg.recordings._kinds import (
    PLACE,
    by_term,
    check_names,
    flag,
    height_of,
    place,
    refuse_unknown,
    sources_of,
    terms_of,
    to_sensor,
    to_table,
)
from probreg.recordings._setup import Setup
from probreg.recordings.files import replacing
from probreg.sensors import known_kinds
from probreg.sensors.frame import LocalFrame
from probreg.validation import positive_number

NUMBERS = ("acceleration_m_s2", "window_s", "gate_m", "max_speed_m_s")
TOP = (*NUMBERS, "origin", "sensor")


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
    refuse_unknown(content, TOP, "the top level")
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
    flat = not any(known_kinds()[table["kind"]].kind.coordinates == 3 for table in tables)
    sensors = tuple(to_sensor(table, frame, 2 if flat else 3) for table in tables)
    biases = {s.name: terms_of(table, s) for table, s in zip(tables, sensors, strict=True)}
    owned = list(zip(tables, sensors, strict=True))
    prior_sd, limits = (
        {name: sd for t, s in owned for name, sd in by_term(t, key, s, biases[s.name]).items()}
        for key in ("prior_sd", "limits")
    )
    body = frozenset(table["name"] for table in tables if flag(table, "body_frame", False))
    others: dict[str, Any] = {
        key: positive_number(key, content[key]) for key in NUMBERS if key in content
    }
    if frame is not None:
        others["origin"] = frame.latitude_deg, frame.longitude_deg, frame.height_m
    heights = {table["name"]: height_of(table, frame) for table in tables}
    others["heights_m"] = {name: high for name, high in heights.items() if high is not None}
    others["asterix"] = sources_of(tables)
    return Setup(sensors, biases, prior_sd, body, limits=limits, **others)


def _frame(content: Mapping[str, Any], tables: list[dict[str, Any]]) -> LocalFrame | None:
    """Frame about the origin, or about the first sensor when all are given by latitude."""
    if "origin" in content:
        origin = content["origin"]
        if not isinstance(origin, dict):
            raise InvalidInputError(f"origin is {origin!r}; a table of {', '.join(PLACE)}.")
        refuse_unknown(origin, PLACE, "origin")
        return LocalFrame(*place(origin, "origin"))
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
    lines = [f"{key} = {_toml(value)}" for key, value in top.items()]
    for sensor in setup.sensors:
        lines += ["", "[[sensor]]"]
        lines += [f"{key} = {_toml(value)}" for key, value in to_table(setup, sensor).items()]
    with replacing(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
