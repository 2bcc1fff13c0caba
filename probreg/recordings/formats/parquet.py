"""Parquet: a table with types, column by column."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import IO, ClassVar

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from probreg.errors import InvalidInputError
from probreg.recordings._stream import Change, changed
from probreg.recordings.formats._table import TableFormat

BATCH_ROWS = 200_000


class Parquet(TableFormat):
    """A table with types; one file."""

    endings: ClassVar[tuple[str, ...]] = (".parquet",)

    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        """Batches of the file's own types."""
        with path.open("rb") as handle:
            file = _open(handle, path)
            try:
                yield from file.iter_batches(batch_size=BATCH_ROWS)
            except (OSError, pa.ArrowException) as error:
                raise InvalidInputError(f"{path} is damaged: {error}.") from None

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


def _open(file: IO[bytes], path: Path) -> pq.ParquetFile:
    try:
        return pq.ParquetFile(file)
    except pa.ArrowInvalid as error:
        raise InvalidInputError(
            f"{path} is no complete Parquet file ({error}): it is cut off or of another format."
        ) from None
