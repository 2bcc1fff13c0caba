"""What a table is read from and rewritten by: a stream of batches of columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

import pyarrow as pa

RowName = Callable[[int], str]
Change = Callable[[pa.RecordBatch, int], pa.RecordBatch]  # of a batch and its first row


class Batches(Protocol):
    """What a table, or a piece of one, is read from."""

    def batches(self, path: Path) -> Iterator[pa.RecordBatch]:
        """Record batches of a file."""

    def row_names(self, path: Path) -> RowName:
        """What names a file's rows: from a number, from 0, to what an editor shows."""


class Stream(Batches, Protocol):
    """How one kind of file holds a table."""

    def rewrite(self, path: Path, like: Path, change: Change) -> None:
        """Write a file that is as another one but for a change of its batches."""

    def remarks(self, path: Path) -> tuple[str, ...]:
        """What is odd about a file but no error."""


def changed(batches: Iterator[pa.RecordBatch], change: Change) -> Iterator[pa.RecordBatch]:
    """Batches of columns, changed one after another."""
    start = 0
    for batch in batches:
        yield change(batch, start)
        start += len(batch)
