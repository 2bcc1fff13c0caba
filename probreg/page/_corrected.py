"""Corrected recordings as files of the form they came in, and back."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from probreg.recordings import Recording, Setup, table
from probreg.recordings.formats import format_of
from probreg.recordings.table import Reading
from probreg.typing import FloatArray

Change = Callable[[Recording, Setup, FloatArray], Recording]


@dataclass(frozen=True, eq=False)
class Source:
    """The table that a recording came from.

    Parameters
    ----------
    path : Path
    reading : Reading
    """

    path: Path
    reading: Reading

    def row_name(self, report: int) -> str:
        """What the reader of the file knows a report by, as errors name it too."""
        return self._row_names(int(self.reading.rows[report]))

    @cached_property
    def _row_names(self) -> Callable[[int], str]:
        return format_of(self.path).row_names(self.path)


def read_source(path: str | Path, setup: Setup, *, trust_units: bool = False) -> Source:
    """Read a table, see `probreg.recordings.table.read`."""
    return Source(Path(path), table.read(path, setup, trust_units=trust_units))


def write_changed(
    path: str | Path, source: Source, setup: Setup, theta: FloatArray, change: Change
) -> None:
    """Write a table like the source, corrected or restored by theta (p,).

    Raises
    ------
    InvalidInputError
        See `probreg.recordings.table.write`.
    """
    recording = source.reading.recording
    # reports carry their number through the change, which sorts them by the new time
    numbered = dataclasses.replace(recording, target=np.arange(len(recording)), labels=())
    changed = change(numbered, setup, theta)
    rows = source.reading.rows[changed.target]
    table.write(path, changed, like=source.path, setup=setup, rows=rows)
