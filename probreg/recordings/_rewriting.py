"""Changed recordings as tables of the form they were read from, other cells as they were."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa

from probreg.errors import InvalidInputError
from probreg.recordings import _columns as columns
from probreg.recordings._heights import places, slanted
from probreg.recordings._kinds import factor
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.recordings._table_reading import TableReading
from probreg.recordings.files import replacing
from probreg.sensors import Sensor
from probreg.sensors.geometry import wrap_angle
from probreg.typing import FloatArray, IntArray


def rewrite(
    old: TableReading, path: str | Path, recording: Recording, setup: Setup, rows: IntArray | None
) -> None:
    """Write a table like `old`, see `probreg.recordings.table.write`."""
    path, like = Path(path), old.path
    if path.suffix.lower() != like.suffix.lower():
        raise InvalidInputError(f"{path} must end with {like.suffix}, as {like} does.")
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
        old.stream.rewrite(part, like, partial(_apply, moved, old.signed))


def _changes(
    old: TableReading, new: Recording, setup: Setup, back: IntArray, rows: IntArray
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
