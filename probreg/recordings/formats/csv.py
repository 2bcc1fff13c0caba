"""Comma-separated values: a table as text, with the names of the columns in the first line."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, ClassVar

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv as pacsv

from probreg.errors import InvalidInputError
from probreg.recordings._arrivals import Piece
from probreg.recordings._stream import Batches, Change, RowName, changed
from probreg.recordings.formats._table import GrowingTable

BLOCK_BYTES = 16 << 20
BOM = b"\xef\xbb\xbf"


class Csv(GrowingTable):
    """A table as text; every cell is read as text, so that it can be written again as it was."""

    endings: ClassVar[tuple[str, ...]] = (".csv",)
    piece_bytes: ClassVar[int | None] = 1 << 20

    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        """Every cell as text."""
        with path.open("rb") as file:
            yield from _batches(file, path)

    def head_length(self, content: bytes) -> int | None:
        """Bytes of the line of names; None while it is incomplete."""
        return content.find(b"\n") + 1 or None

    def complete_length(self, body: bytes) -> int:
        """Bytes of the lines that are ended."""
        return body.rfind(b"\n") + 1

    def of_piece(self, piece: Piece) -> Batches:
        """The rows of some lines."""
        return _Lines(piece)

    def rewrite(self, path: Path, like: Path, change: Change) -> None:
        """Keep line ends and byte order mark."""
        with like.open("rb") as file:
            first = file.readline()
        end = "\r\n" if first.endswith(b"\r\n") else "\n"
        encoding = "utf-8-sig" if first.startswith(BOM) else "utf-8"
        with path.open("w", newline="", encoding=encoding) as out:
            writer = csv.writer(out, lineterminator=end)
            writer.writerow(_names(like))
            for batch in changed(self.batches(like), change):
                columns = [column.to_pylist() for column in batch.columns]
                writer.writerows(zip(*columns, strict=True))

    def create(self, path: Path, frame: pd.DataFrame) -> None:
        """Write a new table."""
        frame.to_csv(path, index=False)

    def row_names(self, path: Path) -> RowName:
        """Lines, counted only when one must be named; blank ones hold no row."""
        with path.open("rb") as file:
            return _line_names(file, 0)

    def remarks(self, path: Path) -> tuple[str, ...]:
        """A last line that may be cut off."""
        with path.open("rb") as file:
            file.seek(-1, 2)
            if file.read(1) in b"\r\n":
                return ()
        return (f"{path} does not end with a line break: its last line may be cut off.",)


@dataclass(frozen=True)
class _Lines:
    """Some lines of a file, under its line of names."""

    piece: Piece

    @property
    def content(self) -> io.BytesIO:
        return io.BytesIO(self.piece.head + self.piece.body)

    @property
    def skipped(self) -> int:
        return self.piece.lines - 1  # the line of names is counted with the body

    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        yield from _batches(self.content, path, self.skipped)

    def row_names(self, path: Path) -> RowName:
        return _line_names(self.content, self.skipped)


def _batches(file: IO[bytes], path: Path, skipped: int = 0) -> Iterator[pa.RecordBatch]:
    """Every cell as text; so many lines were left out after the first."""
    names = _header(file, path)
    types = dict.fromkeys(names, pa.string())
    file.seek(0)
    try:
        yield from pacsv.open_csv(
            file,
            pacsv.ReadOptions(use_threads=False, block_size=BLOCK_BYTES),
            pacsv.ParseOptions(),
            pacsv.ConvertOptions(column_types=types, strings_can_be_null=False),
        )
    except pa.ArrowInvalid as error:
        file.seek(0)
        raise _explain(file, path, len(names), error, skipped) from None


def _line_names(file: IO[bytes], skipped: int) -> RowName:
    lines = np.array([n for n, line in enumerate(file, start=1) if line.strip()][1:])
    return lambda row: f"line {lines[row] + skipped}" if row < len(lines) else f"row {row + 1}"


def _names(path: Path) -> list[str]:
    with path.open("rb") as file:
        return _header(file, path)


def _header(file: IO[bytes], path: Path) -> list[str]:
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


def _explain(
    file: IO[bytes], path: Path, columns: int, error: pa.ArrowInvalid, skipped: int
) -> InvalidInputError:
    """Find the line that could not be read: a wrong encoding or a wrong number of cells."""
    for row, line in enumerate(file, start=1):
        number = row if row == 1 else row + skipped
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
