"""CSV and Parquet as streams of batches of columns, read and rewritten alike."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq

from probreg.errors import InvalidInputError

BLOCK_BYTES = 16 << 20
BATCH_ROWS = 200_000
BOM = b"\xef\xbb\xbf"
RowName = Callable[[int], str]
Change = Callable[[pa.RecordBatch, int], pa.RecordBatch]  # of a batch and its first row


@dataclass(frozen=True)
class Format:
    """How one kind of file is read and rewritten.

    Attributes
    ----------
    batches : callable
        From a path to its record batches.
    rewrite : callable
        From a path, the file to imitate and a change of batches, to the written file.
    row_names : callable
        From a path to what names its rows: from a number, from 0, to what an editor shows.
    remarks : callable
        From a path to what is odd about the file but no error.
    """

    batches: Callable[[Path], Iterator[pa.RecordBatch]]
    rewrite: Callable[[Path, Path, Change], None]
    row_names: Callable[[Path], RowName]
    remarks: Callable[[Path], tuple[str, ...]]


def _changed(batches: Iterator[pa.RecordBatch], change: Change) -> Iterator[pa.RecordBatch]:
    start = 0
    for batch in batches:
        yield change(batch, start)
        start += len(batch)


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


def _csv_batches(path: Path) -> Iterator[pa.RecordBatch]:
    """Every cell as text, so that it can be written again as it was."""
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


def _csv_rewrite(path: Path, like: Path, change: Change) -> None:
    with like.open("rb") as file:
        first = file.readline()
    end = "\r\n" if first.endswith(b"\r\n") else "\n"
    encoding = "utf-8-sig" if first.startswith(BOM) else "utf-8"
    with path.open("w", newline="", encoding=encoding) as out:
        writer = csv.writer(out, lineterminator=end)
        writer.writerow(_header(like))
        for batch in _changed(_csv_batches(like), change):
            columns = [column.to_pylist() for column in batch.columns]
            writer.writerows(zip(*columns, strict=True))


def _csv_row_names(path: Path) -> RowName:
    """Lines are counted only when one must be named; blank ones hold no row."""
    with path.open("rb") as file:
        lines = np.array([n for n, line in enumerate(file, start=1) if line.strip()][1:])
    return lambda row: f"line {lines[row]}" if row < len(lines) else f"row {row + 1}"


def _parquet_row_names(path: Path) -> RowName:
    return lambda row: f"row {row + 1}"


def _csv_remarks(path: Path) -> tuple[str, ...]:
    with path.open("rb") as file:
        file.seek(-1, 2)
        if file.read(1) in b"\r\n":
            return ()
    return (f"{path} does not end with a line break: its last line may be cut off.",)


def _open_parquet(file: IO[bytes], path: Path) -> pq.ParquetFile:
    try:
        return pq.ParquetFile(file)
    except pa.ArrowInvalid as error:
        raise InvalidInputError(
            f"{path} is no complete Parquet file ({error}): it is cut off or of another format."
        ) from None


def _parquet_batches(path: Path) -> Iterator[pa.RecordBatch]:
    with path.open("rb") as handle:
        file = _open_parquet(handle, path)
        try:
            yield from file.iter_batches(batch_size=BATCH_ROWS)
        except (OSError, pa.ArrowException) as error:
            raise InvalidInputError(f"{path} is damaged: {error}.") from None


def _parquet_rewrite(path: Path, like: Path, change: Change) -> None:
    writer = None
    try:
        for batch in _changed(_parquet_batches(like), change):
            writer = writer or pq.ParquetWriter(path, batch.schema)
            writer.write_batch(batch)
    finally:
        if writer:
            writer.close()


FORMATS = {
    ".csv": Format(_csv_batches, _csv_rewrite, _csv_row_names, _csv_remarks),
    ".parquet": Format(_parquet_batches, _parquet_rewrite, _parquet_row_names, lambda _: ()),
}


def format_of(path: Path) -> Format:
    """Choose by the ending of the name.

    Raises
    ------
    InvalidInputError
        An ending that is not known.
    """
    if path.suffix.lower() not in FORMATS:
        raise InvalidInputError(f"{path} ends with none of {', '.join(FORMATS)}; convert it.")
    return FORMATS[path.suffix.lower()]
