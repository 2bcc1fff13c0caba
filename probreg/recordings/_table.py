"""Tables of reports into recordings."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import checks
from probreg.recordings._heights import bring_down
from probreg.recordings._recording import Recording
from probreg.recordings._rewriting import rewrite
from probreg.recordings._rows import Rows
from probreg.recordings._setup import Setup
from probreg.recordings._stream import Stream
from probreg.recordings._table_reading import TableReading
from probreg.recordings._units import refuse_kilometres, refuse_milliseconds, refuse_radians
from probreg.typing import IntArray

ROW_LIMIT = 10_000_000
DAY_S = 86_400.0


def read_table(
    stream: Stream, path: Path, setup: Setup, *, row_limit: int, trust_units: bool
) -> TableReading:
    """Read a table, see `probreg.recordings.table.read`."""
    rows = Rows(stream, path, setup)
    try:
        return _read(rows, row_limit, trust_units)
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None
    except InvalidInputError as error:
        said = str(error)
        raise InvalidInputError(said if str(path) in said else f"{path}: {said}") from None


def _read(rows: Rows, row_limit: int, trust_units: bool) -> TableReading:
    arrays = rows.read(row_limit)
    order = np.argsort(arrays["time"], kind="stable")
    notes = (*rows.stream.remarks(rows.path), *_notes(rows, arrays))
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
    return TableReading(
        rows.path,
        recording,
        (*notes, *said),
        partial(_write_changed, rows.stream, rows.path, order),
        stream=rows.stream,
        rows=order,
        signed=bool((cells < 0.0).any()),
        height_m=None if height is None else height[order],
        geodetic=rows.geodetic,
    )


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
    rewrite(now, path, changed, setup, rows[order])


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
