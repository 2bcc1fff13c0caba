"""The journal of a watch: one line of JSON after another, as long as the state says it is."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from probreg.errors import InvalidInputError


def append(path: Path, length: int, line: Mapping[str, Any]) -> int:
    """Write a line after so many bytes; what an end left behind them goes.

    Returns
    -------
    int
        Bytes of the journal now.

    Raises
    ------
    InvalidInputError
        A journal that is shorter than it should be.
    """
    text = json.dumps(line, ensure_ascii=False, allow_nan=False).encode() + b"\n"
    path.touch()
    with path.open("r+b") as file:
        there = file.seek(0, os.SEEK_END)
        if there < length:
            raise InvalidInputError(
                f"{path} has {there} bytes, and had {length} when the state was saved: bring its "
                "beginning back, or begin in another folder."
            )
        file.truncate(length)
        file.seek(length)
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    return length + len(text)
