"""Recordings that are still being made: what has come since the last look, and nothing twice.

`follow` gives a source; `Source.look` the next complete piece after a `Position`, which is all
that going on after an end needs to know. A `Buffer` keeps what came; `cut` takes slices of time.
"""

from __future__ import annotations

import sys
from pathlib import Path

from probreg.recordings._arrivals import Arrivals
from probreg.recordings.growing._completed import completed, said
from probreg.recordings.growing._files import GrowingFile, GrowingFolder
from probreg.recordings.growing._input import GrowingInput
from probreg.recordings.growing._late_kinds import settled
from probreg.recordings.growing._look import Look, Source
from probreg.recordings.growing._position import Position
from probreg.recordings.growing._slices import Ahead, Buffer, Slice, arrive, complete, cut
from probreg.recordings.growing._start import check_start

__all__ = [
    "Ahead",
    "Arrivals",
    "Buffer",
    "GrowingFile",
    "GrowingFolder",
    "GrowingInput",
    "Look",
    "Position",
    "Slice",
    "Source",
    "arrive",
    "check_start",
    "complete",
    "completed",
    "cut",
    "follow",
    "said",
    "settled",
]


def follow(path: str | Path) -> Source:
    """A recording that grows.

    Parameters
    ----------
    path : str or Path
        A table (.csv) or ASTERIX (.ast) that is being written; a folder that gets such files, or
        tables that are complete (.parquet); "-", lines of a CSV table from standard input.
    """
    if str(path) == "-":
        return GrowingInput(sys.stdin.buffer)
    path = Path(path)
    return GrowingFolder(path) if path.is_dir() else GrowingFile(path)
