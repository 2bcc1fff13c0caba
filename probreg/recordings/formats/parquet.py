"""Parquet: a table with types, column by column."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, ClassVar

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from probreg.errors import InvalidInputError
from probreg.recordings._arrivals import Piece
from probreg.recordings._stream import Batches, Change, RowName, changed
from probreg.recordings.formats._table import GrowingTable

BATCH_ROWS = 200_000
MAGIC = b"PAR1"  # at both ends of a file


class Parquet(GrowingTable):
    """A table with types; one file."""

    endings: ClassVar[tuple[str, ...]] = (".parquet",)

    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        """Batches of the file's own types."""
        with path.open("rb") as handle:
            yield from _batches(handle, path)

    def complete_length(self, body: bytes) -> int:
        """The whole file, once its last bytes are those that end one."""
        ended = len(body) > 2 * len(MAGIC) and body.startswith(MAGIC) and body.endswith(MAGIC)
        return len(body) if ended else 0

    def of_piece(self, piece: Piece) -> Batches:
        """The rows of a whole file."""
        return _Content(piece.body)

    def rewrite(self, path: Path, like: Path, change: Change) -> None:
        """Keep types and columns."""
        writer = None
        try:
            for batch in changed(self.batches(like), change):
                writer = writer or pq.ParquetWriter(path, batch.schema)
                writer.write_batch(batch)
        finally:
            if writer:
                writer.close()

    def create(self, path: Path, frame: pd.DataFrame) -> None:
        """Write a new table."""
        frame.to_parquet(path, index=False)


@dataclass(frozen=True)
class _Content:
    """A file that was read already."""

    content: bytes

    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        yield from _batches(io.BytesIO(self.content), path)

    def row_names(self, path: Path) -> RowName:
        return lambda row: f"row {row + 1}"


def _batches(handle: IO[bytes], path: Path) -> Iterator[pa.RecordBatch]:
    file = _open(handle, path)
    try:
        yield from file.iter_batches(batch_size=BATCH_ROWS)
    except (OSError, pa.ArrowException) as error:
        raise InvalidInputError(f"{path} is damaged: {error}.") from None


def _open(file: IO[bytes], path: Path) -> pq.ParquetFile:
    try:
        return pq.ParquetFile(file)
    except pa.ArrowInvalid as error:
        raise InvalidInputError(
            f"{path} is no complete Parquet file ({error}): it is cut off or of another format."
        ) from None
