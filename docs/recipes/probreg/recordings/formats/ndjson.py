"""One JSON object a line, with the keys of a table's columns."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import pandas as pd
import pyarrow as pa
from pyarrow import json

from probreg.errors import InvalidInputError
from probreg.recordings._stream import Change, changed
from probreg.recordings.formats._table import TableFormat


class NdJson(TableFormat):
    """A table as text, one object a line."""

    endings: ClassVar[tuple[str, ...]] = (".ndjson",)

    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        """Columns by key; a line that is no object is an error."""
        try:
            yield from json.read_json(path).to_batches()
        except pa.ArrowInvalid as error:
            raise InvalidInputError(f"{path} is not one JSON object a line: {error}") from None

    def rewrite(self, path: Path, like: Path, change: Change) -> None:
        """Write the changed batches."""
        self.create(path, pa.Table.from_batches(changed(self.batches(like), change)).to_pandas())

    def create(self, path: Path, frame: pd.DataFrame) -> None:
        """Write a new table."""
        frame.to_json(path, orient="records", lines=True, double_precision=15)
