"""Tables of reports into recordings."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import checks
from probreg.recordings._arrivals import Arrivals, chosen, in_time
from probreg.recordings._heights import (
    Beside,
    add_beside,
    against_prior,
    beside_kinds,
    heights_assumed,
    in_order,
)
from probreg.recordings._kinds import factor
from probreg.recordings._recording import Recording
from probreg.recordings._rewriting import rewrite
from probreg.recordings._rows import Rows
from probreg.recordings._setup import Setup
from probreg.recordings._stream import Batches, Stream
from probreg.recordings._table_reading import TableReading
from probreg.recordings._units import (
    refuse_feet,
    refuse_kilometres,
    refuse_milliseconds,
    refuse_radians,
)
from probreg.typing import FloatArray, IntArray

ROW_LIMIT = 10_000_000
DAY_S = 86_400.0


def read_table(
    stream: Stream, path: Path, setup: Setup, *, row_limit: int, trust_units: bool
) -> TableReading:
    """Read a table, see `probreg.recordings.table.read`."""
    with _names(path):
        return _read(stream, Rows(stream, path, setup), row_limit, trust_units)


def read_piece(source: Batches, path: Path, setup: Setup) -> Arrivals:
    """Read a piece of a table in the order of its rows; what needs a whole one is not checked.

    Raises
    ------
    InvalidInputError
        With the line or column, and what to do.
    """
    with _names(path):
        rows = Rows(source, path, setup)
        arrays = rows.read(ROW_LIMIT)
        arrays.pop("azimuth_deg")
        whole, _ = _beside(rows, arrays)
        arrays = whole.arrays
        arrays.setdefault("beside", np.arange(len(arrays["time"])))
        # reports that stand beside others come with them
        arrays = chosen(arrays, np.argsort(whole.rows, kind="stable"))
        in_time(whole.setup, arrays)
        notes = tuple(f"column {name!r} is not used" for name in rows.others)
        return Arrivals(
            whole.setup, arrays, tuple(rows.labels), tuple(rows.names), (*notes, *whole.notes)
        )


@contextmanager
def _names(path: Path) -> Iterator[None]:
    """Errors name the file."""
    try:
        yield
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    except InvalidInputError as error:
        said = str(error)
        raise InvalidInputError(said if str(path) in said else f"{path}: {said}") from None


def _read(stream: Stream, rows: Rows, row_limit: int, trust_units: bool) -> TableReading:
    arrays = rows.read(row_limit)
    notes = [*stream.remarks(rows.path), *rows.setup.notes, *_notes(rows, arrays)]
    cells = arrays.pop("azimuth_deg")
    if not trust_units:
        refuse_radians(cells[np.isfinite(cells)])
    whole, said = _with_heights(rows, arrays, trust_units)
    order = np.argsort(whole.arrays["time"], kind="stable")
    row = whole.rows[order]
    recording = Recording(
        whole.setup.sensors, labels=tuple(rows.labels), **in_order(whole.arrays, order)
    )
    if not trust_units:
        refuse_milliseconds(recording)
    checks.check(recording, lambda report: rows.where(int(row[report])))
    if not trust_units:
        refuse_kilometres(recording)
    return TableReading(
        rows.path,
        recording,
        whole.setup,
        (*notes, *said, *whole.notes),
        partial(_write_changed, stream, rows.path, row),
        stream=stream,
        rows=row,
        signed=bool((cells < 0.0).any()),
        names=tuple(rows.names),
    )


def _with_heights(
    rows: Rows, arrays: dict[str, Any], trust_units: bool
) -> tuple[Beside, list[str]]:
    """Heights as reports of their own, checked; and what to say of them."""
    whole, given = _beside(rows, arrays)
    said: list[str] = []
    if not trust_units:
        for name, heights in given.items():
            said += refuse_feet(name, heights)
    said += against_prior(whole.setup, np.concatenate([*given.values(), np.zeros(0)]))
    return whole, [*said, *heights_assumed(whole.setup, whole.arrays)]


def _beside(rows: Rows, arrays: dict[str, Any]) -> tuple[Beside, dict[str, FloatArray]]:
    """Heights as reports of their own, and all that are given, by column."""
    cells = {name: rows.beside(arrays, name) for name in beside_kinds() if name in arrays}
    given = {name: arrays.pop(name) for name in cells}
    given = {name: factor(name) * column[~np.isnan(column)] for name, column in given.items()}
    whole = add_beside(dataclasses.replace(rows.setup, geodetic=rows.geodetic), arrays, cells)
    if "own_position" in whole.arrays:
        whole.arrays["own_position"] = whole.arrays["own_position"][:, : whole.setup.dim]
    return whole, given


def _write_changed(
    stream: Stream,
    like: Path,
    rows: IntArray,
    path: Path,
    changed: Recording,
    order: IntArray,
    setup: Setup,
) -> None:
    """Write a table of the same form, see `probreg.recordings.table.write`."""
    now = read_table(stream, like, setup, row_limit=len(changed), trust_units=True)
    rewrite(now, path, changed, rows[order])


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
