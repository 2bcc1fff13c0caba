"""Tables of reports into recordings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import checks
from probreg.recordings._heights import bring_down
from probreg.recordings._reading import Reading
from probreg.recordings._recording import Recording
from probreg.recordings._rewriting import rewrite
from probreg.recordings._rows import Rows
from probreg.recordings._setup import Setup
from probreg.recordings._stream import Stream
from probreg.recordings._units import refuse_kilometres, refuse_milliseconds, refuse_radians
from probreg.typing import FloatArray, IntArray

ROW_LIMIT = 10_000_000
DAY_S = 86_400.0


@dataclass(frozen=True, eq=False)
class TableReading(Reading):
    """What a table gave, and what is needed to write it again.

    Attributes
    ----------
    path, recording, notes
        See `Reading`.
    stream : Stream
        By which the table is read and rewritten.
    rows : ndarray of int, shape (n,)
        Row of the file, from 0, that each report was in.
    signed : bool
        Whether the file has azimuths below zero, rather than from 0 to 360 degrees.
    height_m : ndarray, shape (n,), optional
        Of the target of each report, where it was used to read it; else NaN.
    geodetic : bool
        Whether position sensors report in latitude, longitude and height.
    """

    stream: Stream
    rows: IntArray
    signed: bool
    height_m: FloatArray | None = None
    geodetic: bool = False

    def row_name(self, report: int) -> str:
        """Line or row of the file."""
        return self._row_names(int(self.rows[report]))

    @cached_property
    def _row_names(self) -> Callable[[int], str]:
        return self.stream.row_names(self.path)

    @property
    def changed_ending(self) -> str:
        """That of the file."""
        return self.path.suffix.lower()

    def write_changed(
        self, path: str | Path, changed: Recording, order: IntArray, setup: Setup
    ) -> None:
        """Write a table of the same form, see `probreg.recordings.table.write`."""
        limit = len(changed)
        now = read_table(self.stream, self.path, setup, row_limit=limit, trust_units=True)
        rewrite(now, path, changed, setup, self.rows[order])


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
        rows.stream,
        order,
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
