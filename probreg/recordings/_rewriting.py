"""Changed recordings as tables of the form they were read from, other cells as they were."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa

from probreg.errors import InvalidInputError
from probreg.recordings import _columns as columns
from probreg.recordings._kinds import factor
from probreg.recordings._north import geodetic_axes
from probreg.recordings._recording import Recording
from probreg.recordings._table_reading import TableReading
from probreg.recordings.files import replacing
from probreg.sensors import Sensor
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray, IntArray


def rewrite(
    old: TableReading, path: str | Path, recording: Recording, rows: IntArray | None
) -> None:
    """Write a table like `old`, see `probreg.recordings.table.write`."""
    path, like = Path(path), old.path
    if path.suffix.lower() != like.suffix.lower():
        raise InvalidInputError(f"{path} must end with {like.suffix}, as {like} does.")
    rows = old.rows if rows is None else np.asarray(rows)
    count = len(np.unique(old.rows))
    if len(rows) != len(recording) or not np.array_equal(np.unique(rows), np.arange(count)):
        raise InvalidInputError(f"rows must name each of the {count} rows of {like} once.")
    # a row is of one report, and of those that stand beside it: by other sensors
    known, given = (
        row * len(recording.sensors) + sensor
        for row, sensor in ((old.rows, old.recording.sensor), (rows, recording.sensor))
    )
    back = np.empty(len(rows), dtype=np.int64)
    back[np.argsort(given)] = np.argsort(known)
    if not np.array_equal(known[back], given):
        raise InvalidInputError(
            f"the recording's sensors are not those of the rows of {like}; pass the rows that its "
            "reports belong to."
        )
    moved = _changes(old, recording, back, rows)
    with replacing(path) as part:
        old.stream.rewrite(part, like, partial(_apply, moved, old.signed))


def _changes(
    old: TableReading, new: Recording, back: IntArray, rows: IntArray
) -> dict[str, FloatArray]:
    """What to add to each column's cells, in the order of the file and in the file's units."""
    changes: dict[str, FloatArray] = {}
    count = len(np.unique(rows))
    for k, sensor in enumerate(new.sensors):
        own = np.flatnonzero(new.sensor == k)
        cells = partial(_cells, old, sensor)
        before = cells(old.recording.values[back[own]])
        for column, after in cells(new.values[own]).items():
            change = after - before[column]
            if column in ("azimuth_deg", "longitude_deg"):
                change = np.rad2deg(wrap_angle(np.deg2rad(change)))
            # a height that is missing stays so
            changes.setdefault(column, np.zeros(count))[rows[own]] = np.nan_to_num(change)
    time = np.zeros(count)
    alone = new.alone
    time[rows[alone]] = (new.time - old.recording.time[back])[alone]
    return {**changes, **dict.fromkeys(columns.TIMES, time)}


def _cells(old: TableReading, sensor: Sensor, values: FloatArray) -> dict[str, FloatArray]:
    """Values of one sensor as its columns have them."""
    values = values[:, : len(sensor.bias_names)]
    names = columns.columns_of(sensor, old.names)
    if sensor.name in old.setup.geodetic:
        return dict(zip(names, geodetic_axes(old.setup, sensor).places(values).T, strict=False))
    return {name: values[:, j] / factor(name) for j, name in enumerate(names)}


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
