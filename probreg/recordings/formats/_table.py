"""What formats of tables share: one row a report, cells as they were where nothing changed."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import pyarrow as pa

from probreg.recordings._arrivals import Arrivals, Piece
from probreg.recordings._setup import Setup
from probreg.recordings._stream import Batches, Change, RowName
from probreg.recordings._table import ROW_LIMIT, read_piece, read_table
from probreg.recordings._table_reading import TableReading
from probreg.recordings.formats._format import RecordingFormat
from probreg.recordings.formats._in_pieces import InPieces


class TableFormat(RecordingFormat):
    """A kind of file that holds a table, as a stream of batches of columns."""

    def read(
        self, path: Path, setup: Setup, *, trust_units: bool = False, row_limit: int = ROW_LIMIT
    ) -> TableReading:
        """Read a table, see `probreg.recordings.table.read`."""
        return read_table(self, path, setup, row_limit=row_limit, trust_units=trust_units)

    @abstractmethod
    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        """Record batches of a file."""

    @abstractmethod
    def rewrite(self, path: Path, like: Path, change: Change) -> None:
        """Write a file that is as another one but for a change of its batches."""

    @abstractmethod
    def create(self, path: Path, frame: pd.DataFrame) -> None:
        """Write a new table."""

    def row_names(self, path: Path) -> RowName:
        """What names a file's rows: from a number, from 0, to what an editor shows."""
        return lambda row: f"row {row + 1}"

    def remarks(self, path: Path) -> tuple[str, ...]:
        """What is odd about a file but no error."""
        return ()


class GrowingTable(TableFormat, InPieces):
    """A table whose rows can be read while others are still being written."""

    @abstractmethod
    def of_piece(self, piece: Piece) -> Batches:
        """The rows of a piece."""

    def arrivals(self, piece: Piece, setup: Setup, *, fixed: bool) -> Arrivals | None:
        """Reports of a piece, None where it has none."""
        if not piece.body.strip():
            return None
        return read_piece(self.of_piece(piece), piece.path, setup)
