"""How far a growing recording has been read: what going on after an end needs to know."""

from __future__ import annotations

import dataclasses
import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

BEGINNING_BYTES = 4_096  # by which a file is known, whatever its name


class Seen(NamedTuple):
    """What the file system said of a file when it was last read: unchanged, it has no more."""

    inode: int
    size: int
    changed_ns: int


UNSEEN = Seen(0, 0, 0)


@dataclass(frozen=True)
class FilePosition:
    """How far one file has been read.

    Attributes
    ----------
    name : str
        Of the file in its folder.
    read, lines : int
        Bytes and lines that were read.
    known_by : str
        SHA-256 of the first bytes: of all that were read, or of `BEGINNING_BYTES`.
    seen : Seen
    """

    name: str
    read: int
    lines: int
    known_by: str
    seen: Seen = UNSEEN

    @property
    def beginning(self) -> int:
        """Bytes that the file is known by."""
        return min(self.read, BEGINNING_BYTES)


@dataclass(frozen=True)
class Position:
    """How far a recording has been read.

    Attributes
    ----------
    files : tuple of FilePosition
        Of those that are still there.
    columns : tuple of str
        Of the first file, which every other must have.
    last : float or None
        Time of the last report.
    """

    files: tuple[FilePosition, ...] = ()
    columns: tuple[str, ...] = ()
    last: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Words and numbers that JSON keeps exactly."""
        return dataclasses.asdict(self)

    @classmethod
    def from_json(cls, content: dict[str, Any]) -> Position:
        """The position that `to_json` gave."""
        files = tuple(
            FilePosition(**{**one, "seen": Seen(*one["seen"])}) for one in content["files"]
        )
        return cls(files, tuple(content["columns"]), content["last"])


def digest(content: bytes) -> str:
    """By what a file is known."""
    return hashlib.sha256(content[:BEGINNING_BYTES]).hexdigest()


def seen(path: Path) -> Seen:
    """What the file system says of a file."""
    found = path.stat()
    return Seen(found.st_ino, found.st_size, found.st_mtime_ns)


def fits(path: Path, position: FilePosition) -> bool:
    """Whether a file is the one that a position is of, as long as then or longer."""
    now = seen(path)
    if now == position.seen:
        return True
    if now.size < position.read:
        return False
    with path.open("rb") as file:
        return digest(file.read(position.beginning)) == position.known_by
