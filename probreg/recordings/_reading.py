"""What every file format gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.typing import IntArray

# writes a recording that was changed in time and values to a path, in the form it was read from;
# the array says which report of the reading each of its reports is
Writer = Callable[[Path, Recording, IntArray, Setup], None]


@dataclass(frozen=True, eq=False)
class Reading:
    """What a file gave.

    Attributes
    ----------
    path : Path
    recording : Recording
    setup : Setup
        With what the file told of the sensors: those whose reports were found beside others',
        and which of them report latitudes.
    notes : tuple of str
        What the reader of results should know: columns not used, rows put in order.
    writer : callable, optional
        Of formats that are written too; what others gave is written as a new table.
    """

    path: Path
    recording: Recording
    setup: Setup
    notes: tuple[str, ...] = ()
    writer: Writer | None = None

    def row_name(self, report: int) -> str:
        """What the reader of the file knows a report by, as errors name it too."""
        return f"report {report}"

    @property
    def changed_ending(self) -> str:
        """Ending of the file that `write_changed` writes."""
        return ".csv"
