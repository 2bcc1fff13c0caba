"""Comma-separated values: a table as text, with the names of the columns in the first line."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv as pacsv

from probreg.errors import InvalidInputError
from probreg.recordings._stream import Change, RowName, changed
from probreg.recordings.formats._table import TableFormat

BLOCK_BYTES = 16 << 20
BOM = b"\xef\xbb\xbf"


class Csv(TableFormat):
    """A table as text; every cell is read as text, so that it can be written again as it was."""

    endings: ClassVar[tuple[str, ...]] = (".csv",)

    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        """Every cell as text."""
        names = _header(path)
        types = dict.fromkeys(names, pa.string())
        try:
            yield from pacsv.open_csv(
                path,
                pacsv.ReadOptions(use_threads=False, block_size=BLOCK_BYTES),
                pacsv.ParseOptions(),
                pacsv.ConvertOptions(column_types=types, strings_can_be_null=False),
            )
        except pa.ArrowInvalid as error:
            raise _explain(path, len(names), error) from None

    def rewrite(self, path: Path, like: Path, change: Change) -> None:
        """Keep line ends and byte order mark."""
        with like.open("rb") as file:
            first = file.readline()
        end = "\r\n" if first.endswith(b"\r\n") else "\n"
        encoding = "utf-8-sig" if first.startswith(BOM) else "utf-8"
        with path.open("w", newline="", encoding=encoding) as out:
            writer = csv.writer(out, lineterminator=end)
            writer.writerow(_header(like))
            for batch in changed(self.batches(like), change):
                columns = [column.to_pylist() for column in batch.columns]
                writer.writerows(zip(*columns, strict=True))

    def create(self, path: Path, frame: pd.DataFrame) -> None:
        """Write a new table."""
        frame.to_csv(path, index=False)

    def row_names(self, path: Path) -> RowName:
        """Lines, counted only when one must be named; blank ones hold no row."""
        with path.open("rb") as file:
            lines = np.array([n for n, line in enumerate(file, start=1) if line.strip()][1:])
        return lambda row: f"line {lines[row]}" if row < len(lines) else f"row {row + 1}"

    def remarks(self, path: Path) -> tuple[str, ...]:
        """A last line that may be cut off."""
        with path.open("rb") as file:
            file.seek(-1, 2)
            if file.read(1) in b"\r\n":
                return ()
        return (f"{path} does not end with a line break: its last line may be cut off.",)


def _header(path: Path) -> list[str]:
    with path.open("rb") as file:
        first = file.readline()
    if not first.strip():
        raise InvalidInputError(f"{path} is empty; a line with the names of columns is needed.")
    try:
        names = next(csv.reader(first.decode("utf-8-sig").splitlines()))
    except UnicodeDecodeError:
        raise InvalidInputError(f"{path}, line 1, is not UTF-8; save the file as UTF-8.") from None
    if len(names) == 1 and (";" in names[0] or "\t" in names[0]):
        raise InvalidInputError(f"{path} is not separated by commas; save it so, decimals by '.'.")
    return names


def _explain(path: Path, columns: int, error: pa.ArrowInvalid) -> InvalidInputError:
    """Find the line that could not be read: a wrong encoding or a wrong number of cells."""
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            try:
                text = line.decode("utf-8")
            except UnicodeDecodeError:
                return InvalidInputError(
                    f"{path}, line {number}, is not UTF-8 (the encoding changes there, or the "
                    "file is damaged); save the whole file as UTF-8."
                )
            # a lone carriage return ends a line as well
            cells = next(csv.reader(text.splitlines()), [])
            if cells and len(cells) != columns:
                cut = "" if file.read(1) else ": the file is cut off"
                return InvalidInputError(
                    f"{path}, line {number}, has {len(cells)} cells instead of {columns}{cut}. "
                    "Repair that line."
                )
    return InvalidInputError(f"{path} cannot be read as CSV: {error}")
