"""Columns of a table of reports: their names and limits, and cells into numbers."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Collection, Sequence

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from probreg.errors import InvalidInputError
from probreg.recordings._setup import Setup
from probreg.sensors import Sensor, known_kinds
from probreg.typing import FloatArray, IntArray

COMPONENTS = tuple(  # columns of every kind's reports
    dict.fromkeys(name for owner in known_kinds().values() for name in owner.kind.every_column)
)
GEODETIC = ("latitude_deg", "longitude_deg", "height_m")
OWN = ("own_east_m", "own_north_m", "own_up_m")
TIMES = ("time_s", "time")
KNOWN = ("sensor", "target", "heading_deg", *TIMES, *OWN, *COMPONENTS)
FARTHEST_M = 1e8
LIMITS = {
    **{
        name: (-360.0, 360.0) if name.endswith("_deg") else (-FARTHEST_M, FARTHEST_M)
        for name in (*COMPONENTS, *GEODETIC, *OWN, "heading_deg")
    },
    "range_m": (0.0, FARTHEST_M),
    "elevation_deg": (-90.0, 90.0),
    "latitude_deg": (-90.0, 90.0),
    "flight_level": (-100.0, 3_000.0),
}
# columns by their quantity, whose unit may lack or be another one
QUANTITIES = {
    **{re.sub("_(m_s|m|deg|s)$", "", name): name for name in (*COMPONENTS, "heading_deg")},
    "bearing": "azimuth_deg",
}
OTHER_UNIT = re.compile(
    rf"({'|'.join(QUANTITIES)})(_(km|m|nm|nmi|ft|rad|mrad|deg))?", re.IGNORECASE
)
NUMBER = re.compile(
    r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*|\s*[+-]?(nan|inf|infinity)\s*", re.I
)
Where = Callable[[int], str]


def is_geodetic(sensor: Sensor, names: Collection[str]) -> bool:
    """Tell whether a position sensor reports in latitude, longitude and height."""
    return sensor.cartesian and "east_m" not in names and GEODETIC[0] in names


def of_reports(sensor: Sensor) -> tuple[str, ...]:
    """Columns of a sensor's report components."""
    return sensor.kind.columns[: len(sensor.bias_names)]


def columns_of(sensor: Sensor, names: Collection[str]) -> tuple[str, ...]:
    """Columns of a sensor's report components among the names of a table."""
    if is_geodetic(sensor, names):
        return GEODETIC[: sensor.dim]
    other = next((name for name in sensor.kind.others if name in names), None)
    return of_reports(sensor) if other is None else (other,)


def needed(sensor: Sensor, setup: Setup, names: Collection[str]) -> tuple[str, ...]:
    """Columns of a sensor's reports, and of its place and heading where they need them.

    The height of a position may be missing.
    """
    if sensor.cartesian:
        return columns_of(sensor, names)[:2]
    # without a place of its own it is somewhere on a platform
    alone = sensor.position is None and sensor.azimuth_column is not None
    heading = ("heading_deg",) if sensor.name in setup.body_frame else ()
    return (*columns_of(sensor, names), *(OWN[:2] if alone else ()), *heading)


def check_names(names: Sequence[str], setup: Setup) -> tuple[str, ...]:
    """Check the names of columns; return those that are none of ours and stay as they are.

    Raises
    ------
    InvalidInputError
        Repeated, missing and misspelt ones.
    """
    repeated = [name for k, name in enumerate(names) if name in names[:k]]
    if repeated:
        raise InvalidInputError(f"column {repeated[0]!r} is there twice; rename or remove one.")
    used = {name for sensor in setup.sensors for name in needed(sensor, setup, names)}
    others = [name for name in names if name not in KNOWN and name not in used]
    for name in others:
        meant = _meant(name)
        if meant and meant not in names:
            raise InvalidInputError(
                f"unknown column {name!r}; for {meant!r}, rename it and see to its unit."
            )
    times = [name for name in TIMES if name in names]
    if len(times) != 1:
        raise InvalidInputError(f"one column of {TIMES} is needed; there are {times}.")
    for owner in known_kinds().values():
        same = [name for name in owner.kind.every_column if name in names]
        if owner.kind.others and len(same) > 1:
            raise InvalidInputError(f"columns {same} say the same; remove all but one.")
    if "sensor" not in names:
        raise InvalidInputError("column 'sensor' is missing: the name of each report's sensor.")
    for sensor in setup.sensors:
        missing = [name for name in needed(sensor, setup, names) if name not in names]
        if missing:
            also = f", or in {', '.join(GEODETIC)}" if missing[0] == "east_m" else ""
            raise InvalidInputError(
                f"column {missing[0]!r} is missing; sensor {sensor.name!r} reports in "
                f"{', '.join(needed(sensor, setup, names))}{also}."
            )
        if setup.origin is None and is_geodetic(sensor, names):
            raise InvalidInputError(
                f"sensor {sensor.name!r} reports in latitude and longitude, and the setup has no "
                "place on the earth; give it an origin."
            )
    return tuple(others)


def _meant(name: str) -> str | None:
    """Column that a name may have been meant for."""
    match = OTHER_UNIT.fullmatch(name)
    if match:
        return QUANTITIES[match.group(1).lower()]
    close = difflib.get_close_matches(name.lower(), KNOWN, n=1, cutoff=0.8)
    return close[0] if close else None


def is_text(column: pa.Array) -> bool:
    """Tell texts from numbers by type; every cell of a CSV file is text."""
    return pa.types.is_string(column.type) or pa.types.is_large_string(column.type)


def numbers(column: pa.Array, name: str, where: Where) -> FloatArray:
    """Cells (n,) as floats, NaN where empty.

    Raises
    ------
    InvalidInputError
        A cell that is no number, with its row.
    """
    if is_text(column):
        column = pc.utf8_trim_whitespace(column)
        column = pc.if_else(pc.equal(column, ""), pa.scalar(None, column.type), column)
    try:
        return column.cast(pa.float64()).to_numpy(zero_copy_only=False)
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError):
        texts = enumerate(column.to_pylist())
        bad = ((row, text) for row, text in texts if text and not NUMBER.fullmatch(str(text)))
        row, text = next(bad, (0, column[0].as_py()))
        raise InvalidInputError(
            f"{where(row)}: {name} is {text!r}, no number. Correct the cell (decimals by '.')."
        ) from None


def codes(column: pa.Array, known: dict[str, int], grow: bool) -> tuple[IntArray, list[str]]:
    """Number the texts of a column by `known`: -1 for empty ones and for those not known.

    Returns
    -------
    numbers : ndarray, shape (n,)
    unknown : list of str
        Texts not in `known`; none when it may `grow`.
    """
    if pa.types.is_dictionary(column.type):
        column = column.dictionary_decode()
    texts = pc.utf8_trim_whitespace(pc.fill_null(column.cast(pa.string()), ""))
    encoded = texts.dictionary_encode()
    words = encoded.dictionary.to_pylist()
    unknown = [word for word in words if word and word not in known]
    if grow:
        known.update({word: len(known) + k for k, word in enumerate(unknown)})
        unknown = []
    found = np.array([known.get(word, -1) if word else -1 for word in words], dtype=np.int32)
    return found[encoded.indices.to_numpy()], unknown


def is_clock(column: pa.Array) -> bool:
    """Tell time stamps and ISO 8601, by the first cell, from seconds."""
    if pa.types.is_timestamp(column.type):
        return True
    return bool(is_text(column) and len(column) and not NUMBER.fullmatch(column[0].as_py() or "0"))


def seconds(column: pa.Array, name: str, where: Where) -> FloatArray:
    """Times (n,) as seconds: numbers, time stamps, or ISO 8601 (UTC when it gives no zone).

    Raises
    ------
    InvalidInputError
        Cells that are neither, with the first one's row.
    """
    if not is_clock(column):
        return numbers(column, name, where)
    if pa.types.is_timestamp(column.type):
        column = column.cast(pa.timestamp("ns", column.type.tz)).cast(pa.int64())
        return column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False) / 1e9
    texts = pd.Series(column.to_pylist())
    stamps = pd.to_datetime(texts, utc=True, format="ISO8601", errors="coerce")
    bad = np.flatnonzero(stamps.isna())
    if bad.size:
        raise InvalidInputError(
            f"{where(int(bad[0]))}: {name} is {texts[bad[0]]!r}, not ISO 8601 such as "
            "2024-05-01T12:00:00.250Z. Correct the cell."
        )
    return stamps.dt.as_unit("ns").astype("int64").to_numpy() / 1e9


def add_seconds(column: pa.Array, change: FloatArray) -> pa.Array:
    """Add seconds to a column of clock times, which keeps its type; texts not changed stay."""
    if pa.types.is_timestamp(column.type):
        ns = column.cast(pa.timestamp("ns", column.type.tz)).cast(pa.int64())
        added = pc.add(ns, pa.array(np.rint(change * 1e9).astype(np.int64)))
        return added.cast(pa.timestamp("ns", column.type.tz)).cast(column.type, safe=False)
    texts = column.to_pylist()
    for row in np.flatnonzero(change).tolist():
        stamp = pd.Timestamp(texts[row]) + pd.Timedelta(round(change[row] * 1e9), "ns")
        texts[row] = stamp.isoformat()
    return pa.array(texts, column.type)


def inside(values: FloatArray, name: str, rows: IntArray, where: Where) -> FloatArray:
    """Check that numbers are there and within the limits of their column.

    Raises
    ------
    InvalidInputError
        With the row, and what may be wrong.
    """
    low, high = LIMITS[name]
    bad = np.flatnonzero(~((values >= low) & (values <= high)))
    if bad.size:
        value = values[bad[0]]
        what = "empty or not finite" if not np.isfinite(value) else f"{value:g}"
        raise InvalidInputError(
            f"{where(int(rows[bad[0]]))}: {name} is {what}; it must be from {low:g} to {high:g} "
            f"({bad.size} such). Correct the cell or its unit, or remove the row."
        )
    return values
