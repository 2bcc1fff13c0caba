"""What a growing recording has gained: complete items of a file, and the reports in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.typing import IntArray


class Piece(NamedTuple):
    """Complete items of a file that may still be written.

    Attributes
    ----------
    path : Path
    head : bytes
        What stands once at the beginning of the file, such as the names of columns.
    body : bytes
        The items.
    start, lines : int
        Bytes and lines of the file before the body.
    after : float or None
        Last time so far, from which times of day are counted on.
    """

    path: Path
    head: bytes
    body: bytes
    start: int = 0
    lines: int = 0
    after: float | None = None


@dataclass(frozen=True, eq=False)
class Arrivals:
    """Reports in the order in which they came.

    Attributes
    ----------
    setup : Setup
        With the sensors that were found beside others.
    arrays : dict of str to ndarray
        Of a `Recording`, `beside` among them.
    labels : tuple of str
        Of the targets, by their number in this piece.
    columns : tuple of str
        Of the file.
    notes : tuple of str
    """

    setup: Setup
    arrays: dict[str, Any]
    labels: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.arrays["time"])


def chosen(arrays: dict[str, Any], rows: IntArray) -> dict[str, Any]:
    """Arrays of some reports, each with those it stands beside, in the order of rows."""
    moved = {name: array[rows] for name, array in arrays.items()}
    if "beside" in arrays:
        number = np.full(len(arrays["time"]), -1)
        number[rows] = np.arange(len(rows))
        moved["beside"] = number[moved["beside"]]
    return moved


def joined(parts: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Arrays of several pieces, one after the other."""
    starts = np.cumsum([0, *(len(part["time"]) for part in parts)])
    shifted = [
        {**part, "beside": part["beside"] + start}
        for part, start in zip(parts, starts[:-1], strict=True)
    ]
    return {name: np.concatenate([part[name] for part in shifted]) for name in parts[0]}


def in_time(setup: Setup, arrays: dict[str, Any], labels: tuple[str, ...] = ()) -> Recording:
    """The recording that arrivals make once they are sorted by time."""
    order = np.argsort(arrays["time"], kind="stable")
    return Recording(setup.sensors, labels=labels, **chosen(arrays, order))
