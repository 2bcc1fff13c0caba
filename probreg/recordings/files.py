"""Files that are complete or not there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from probreg.errors import InvalidInputError


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a temporary name in the same folder; rename it to `path` when all went well.

    Raises
    ------
    InvalidInputError
        A folder that is not there or cannot be written.
    """
    path = Path(path)
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        part.touch()
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be written: {error.strerror}.") from None
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
