"""What a table of reports gave."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import cached_property

from probreg.recordings._reading import Reading
from probreg.recordings._stream import Stream
from probreg.typing import IntArray


@dataclass(frozen=True, eq=False)
class TableReading(Reading):
    """What a table gave, and what is needed to write it again.

    Attributes
    ----------
    path, recording, setup, notes, writer
        See `Reading`.
    stream : Stream
        By which the table is read and rewritten.
    rows : ndarray of int, shape (n,)
        Row of the file, from 0, that each report was in.
    signed : bool
        Whether the file has azimuths below zero, rather than from 0 to 360 degrees.
    names : tuple of str
        Of the columns.
    """

    _: KW_ONLY
    stream: Stream
    rows: IntArray
    signed: bool
    names: tuple[str, ...] = ()

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
