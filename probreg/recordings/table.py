"""Reports in a table, CSV or Parquet: one row a report, units in the names of the columns.

Columns: `time_s` or `time` (POSIX seconds or ISO 8601), `sensor`, and what the sensor reports:
`range_m`, `azimuth_deg`, `elevation_deg` of radars, `azimuth_deg` of bearing sensors, `east_m`,
`north_m`, `up_m` of position sensors. Position sensors may report in `latitude_deg`,
`longitude_deg` and `height_m` instead. Optional: `target`, `own_east_m`, `own_north_m`,
`own_up_m` of a moving platform, `heading_deg` of it (compass). Others stay as they are.

With `height_m` of the target (above the ellipsoid, or above the plane of a frame without an
origin) ranges of 2-D radars are slant ranges, and are brought down into the plane as
`probreg.recordings.asterix` does; without, they are taken as ground ranges.

With an origin on the earth, azimuth and heading count from true north where the sensor stands,
and are turned to the north of the common frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from probreg.errors import InvalidInputError
from probreg.recordings import _columns as columns
from probreg.recordings import checks
from probreg.recordings._heights import bring_down, places, slanted
from probreg.recordings._kinds import factor
from probreg.recordings._recording import Recording
from probreg.recordings._rows import Rows
from probreg.recordings._setup import Setup
from probreg.recordings._units import refuse_kilometres, refuse_milliseconds, refuse_radians
from probreg.recordings.files import replacing
from probreg.recordings.formats import format_of
from probreg.sensors import Sensor
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray, IntArray

ROW_LIMIT = 10_000_000
DAY_S = 86_400.0


@dataclass(frozen=True, eq=False)
class Reading:
    """What a file gave.

    Attributes
    ----------
    recording : Recording
    rows : ndarray of int, shape (n,)
        Row of the file, from 0, that each report was in.
    notes : tuple of str
        What the reader of results should know: columns not used, rows put in order.
    signed : bool
        Whether the file has azimuths below zero, rather than from 0 to 360 degrees.
    height_m : ndarray, shape (n,), optional
        Of the target of each report, where it was used to read it; else NaN.
    geodetic : bool
        Whether position sensors report in latitude, longitude and height.
    """

    recording: Recording
    rows: IntArray
    notes: tuple[str, ...]
    signed: bool
    height_m: FloatArray | None = None
    geodetic: bool = False


def read(
    path: str | Path, setup: Setup, *, row_limit: int = ROW_LIMIT, trust_units: bool = False
) -> Reading:
    """Read a table of reports.

    The file is streamed; what it takes in memory is about 250 bytes a report.
    Rows may be in any order and are sorted by time. Times of day that fall back past midnight
    are refused: within one sensor, from below a day, by more than half a day.

    Parameters
    ----------
    path : str or Path
        Ends with .csv or .parquet.
    setup : Setup
    row_limit : int
        Longer files are refused.
    trust_units : bool
        Whether to leave out the checks for radians, kilometres and milliseconds by the look of
        the numbers.

    Returns
    -------
    Reading

    Raises
    ------
    InvalidInputError
        With the line or column, and what to do.
    """
    path = Path(path)
    rows = Rows(path, setup)
    try:
        return _read(rows, row_limit, trust_units)
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    except InvalidInputError as error:
        said = str(error)
        raise InvalidInputError(said if str(path) in said else f"{path}: {said}") from None


def _read(rows: Rows, row_limit: int, trust_units: bool) -> Reading:
    arrays = rows.read(row_limit)
    order = np.argsort(arrays["time"], kind="stable")
    notes = (*format_of(rows.path).remarks(rows.path), *_notes(rows, arrays))
    cells = arrays.pop("azimuth_deg")
    if not trust_units:
        refuse_radians(cells[np.isfinite(cells)])
    height, said = bring_down(rows.setup, arrays, rows.where)
    recording = Recording(
        rows.setup.sensors,
        labels=tuple(rows.labels),
        **{name: array[order] for name, array in arrays.items()},
    )
    if not trust_units:
        refuse_milliseconds(recording, rows.setup.window_s)
    checks.check(recording, rows.setup.window_s, lambda report: rows.where(int(order[report])))
    if not trust_units:
        refuse_kilometres(recording)
    return Reading(
        recording,
        order,
        (*notes, *said),
        bool((cells < 0.0).any()),
        None if height is None else height[order],
        rows.geodetic,
    )


def _notes(rows: Rows, arrays: dict[str, Any]) -> tuple[str, ...]:
    """Say what columns are not used and whether rows were sorted; refuse clocks past midnight."""
    notes = [f"column {name!r} is not used" for name in rows.others]
    back = np.diff(arrays["time"]) < 0.0
    if not back.any():
        return tuple(notes)
    for k, sensor in enumerate(rows.setup.sensors):
        own = np.flatnonzero(arrays["sensor"] == k)
        time = arrays["time"][own]
        fall = np.flatnonzero(np.diff(time) < -0.5 * DAY_S)
        if fall.size and time.min() >= 0.0 and time.max() <= DAY_S:
            row = int(own[fall[0] + 1])
            raise InvalidInputError(
                f"{rows.where(row)}: the time of sensor {sensor.name!r} falls from "
                f"{time[fall[0]]:.3f} to {time[fall[0] + 1]:.3f} s: a time of day past midnight? "
                f"Add {DAY_S:.0f} s to the rows after it, or sort the file by time."
            )
    notes.append(f"{back.sum()} rows were earlier than the row before; all were sorted by time")
    return tuple(notes)


def write(
    path: str | Path,
    recording: Recording,
    *,
    like: str | Path,
    setup: Setup,
    rows: IntArray | None = None,
) -> None:
    """Write a changed recording as a table of the same form as the one it was read from.

    Cells whose values did not change are written as they were, and so are all other columns
    and the order of rows. Nothing is left of a file that could not be completed.

    Parameters
    ----------
    path : str or Path
        With the same ending as `like`.
    recording : Recording
        Of as many reports as `like` has rows: changed in time and values.
    like : str or Path
        The table that was read.
    setup : Setup
        With which it was read.
    rows : ndarray of int, shape (n,), optional
        Row of the table that each report belongs to; those of `read` unless reports changed
        places.

    Raises
    ------
    InvalidInputError
        A table that cannot be read or does not belong to the recording, a path that cannot be
        written.
    """
    path, like = Path(path), Path(like)
    if path.suffix.lower() != like.suffix.lower():
        raise InvalidInputError(f"{path} must end with {like.suffix}, as {like} does.")
    old = read(like, setup, row_limit=len(recording), trust_units=True)
    rows = old.rows if rows is None else np.asarray(rows)
    if not np.array_equal(np.sort(rows), np.arange(len(old.rows))):
        raise InvalidInputError(f"rows must name each of the {len(old.rows)} rows of {like} once.")
    back = np.argsort(old.rows)[rows]
    if not np.array_equal(old.recording.sensor[back], recording.sensor):
        raise InvalidInputError(
            f"the recording's sensors are not those of the rows of {like}; pass the rows that its "
            "reports belong to."
        )
    moved = _changes(old, recording, setup, back, rows)
    with replacing(path) as part:
        format_of(like).rewrite(part, like, partial(_apply, moved, old.signed))


def _changes(
    old: Reading, new: Recording, setup: Setup, back: IntArray, rows: IntArray
) -> dict[str, FloatArray]:
    """What to add to each column's cells, in the order of the file and in the file's units."""
    changes: dict[str, FloatArray] = {}
    for k, sensor in enumerate(new.sensors):
        own = np.flatnonzero(new.sensor == k)
        height = None if old.height_m is None else old.height_m[back[own]]
        cells = partial(_cells, setup, sensor, old.geodetic, height)
        before = cells(old.recording.values[back[own]])
        for column, after in cells(new.values[own]).items():
            change = after - before[column]
            if column in ("azimuth_deg", "longitude_deg"):
                change = np.rad2deg(wrap_angle(np.deg2rad(change)))
            changes.setdefault(column, np.zeros(len(rows)))[rows[own]] = change
    time = np.zeros(len(rows))
    time[rows] = new.time - old.recording.time[back]
    return {**changes, **dict.fromkeys(columns.TIMES, time)}


def _cells(
    setup: Setup, sensor: Sensor, geodetic: bool, height: FloatArray | None, values: FloatArray
) -> dict[str, FloatArray]:
    """Values of one sensor as its columns have them, but for a constant turn of azimuth."""
    values = values[:, : len(sensor.bias_names)]
    if geodetic and sensor.cartesian and height is not None:
        found = places(setup, values, height)
        return dict(zip(columns.GEODETIC, found.T[: max(2, sensor.dim)], strict=False))
    if columns.is_slant(sensor) and height is not None and np.isfinite(height).all():
        values = slanted(setup, sensor, values, height)
    return {name: values[:, j] / factor(name) for j, name in enumerate(columns.of_reports(sensor))}


def _apply(
    changes: dict[str, FloatArray], signed: bool, batch: pa.RecordBatch, start: int
) -> pa.RecordBatch:
    """Add to one batch what changed in its rows; other cells and columns stay."""
    for position, name in enumerate(batch.schema.names):
        # decided by the whole column: the type of a column is the same in every batch
        if name not in changes or not changes[name].any():
            continue
        cells = batch.column(position)
        change = changes[name][start : start + len(batch)]
        if name in columns.TIMES and columns.is_clock(cells):
            added = columns.add_seconds(cells, change)
        else:
            added = _add(cells, change, name, signed)
        batch = batch.set_column(position, name, added)
    return batch


def _add(cells: pa.Array, change: FloatArray, name: str, signed: bool) -> pa.Array:
    rows = np.flatnonzero(change)
    values = columns.numbers(cells, name, str).copy()
    new = values[rows] + change[rows]
    if name == "azimuth_deg":
        new = np.rad2deg(wrap_angle(np.deg2rad(new))) if signed else np.mod(new, 360.0)
    if columns.is_text(cells):
        texts = cells.to_pylist()
        for row, value in zip(rows.tolist(), new.tolist(), strict=True):
            texts[row] = repr(value)
        return pa.array(texts, cells.type)
    values[rows] = new
    return pa.array(values, pa.float64(), mask=np.isnan(values))
