"""One look at a growing recording: the next complete piece of it, if there is one."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple, Protocol

from probreg.errors import InvalidInputError
from probreg.recordings._arrivals import Arrivals, Piece
from probreg.recordings._setup import Setup
from probreg.recordings.formats import InPieces, choose, known_formats
from probreg.recordings.growing._late_kinds import with_fixed
from probreg.recordings.growing._position import (
    BEGINNING_BYTES,
    UNSEEN,
    FilePosition,
    Position,
    digest,
    seen,
)

HEAD_BYTES = 1 << 16  # more than any line of names


class Look(NamedTuple):
    """What a look gave.

    Attributes
    ----------
    arrivals : Arrivals or None
        New reports, if any.
    position : Position
        After them; the one before if there was nothing to read.
    waiting : tuple of str
        What is there but cannot be read yet.
    """

    arrivals: Arrivals | None
    position: Position
    waiting: tuple[str, ...] = ()


class Source(Protocol):
    """Where a recording comes from."""

    def look(self, position: Position, setup: Setup, *, fixed: bool) -> Look:
        """The next piece after a position.

        Parameters
        ----------
        position : Position
        setup : Setup
            Of the last arrivals.
        fixed : bool
            Whether sensors and their places stay as they are; reports of a kind that is new are
            then numbered beyond the sensors, and `cut` counts them.

        Raises
        ------
        InvalidInputError
            Files that cannot be read, that are no longer what they were, and what cannot be
            meant, with its place.
        """

    @property
    def ended(self) -> bool:
        """Whether nothing more can come."""


def growing_format(path: Path) -> InPieces:
    """The format of a file that may be read while it grows.

    Raises
    ------
    InvalidInputError
        None of those that can.
    """
    return choose(path, [form for form in known_formats() if isinstance(form, InPieces)])


def read_file(
    path: Path, form: InPieces, known: FilePosition | None, last: float | None
) -> Piece | None:
    """The next complete items of a file, None while there are none.

    Raises
    ------
    InvalidInputError
        Another end than there was of a file that must not change, items that never end.
    """
    read = 0 if known is None else known.read
    if known is not None and form.piece_bytes is None:
        if seen(path).size != read:
            raise InvalidInputError(
                f"{path} had {read} bytes when it was read, and now has another number; files of "
                "this format must not change. Write new reports into new files."
            )
        return None
    with path.open("rb") as file:
        content = file.read(HEAD_BYTES)
        length = form.head_length(content)
        if length is None:
            _refuse_endless(path, content, HEAD_BYTES)
            return None
        head, start = content[:length], max(read, length)
        file.seek(start)
        body = file.read(form.piece_bytes)
    whole = form.complete_length(body)
    if not whole:
        _refuse_endless(path, body, form.piece_bytes)
        return None
    lines = head.count(b"\n") if known is None else known.lines
    return Piece(path, head, body[:whole], start, lines, last)


def _refuse_endless(path: Path, content: bytes, limit: int | None) -> None:
    if limit is not None and len(content) >= limit:
        raise InvalidInputError(
            f"{path} has no end of a line or block in {len(content)} bytes: it is damaged, or of "
            "another format."
        )


def taken(
    piece: Piece, form: InPieces, position: Position, setup: Setup, *, fixed: bool
) -> tuple[Arrivals | None, Position]:
    """Reports of a piece, and the position after it but for its file.

    Raises
    ------
    InvalidInputError
        Other columns than those of the first file.
    """
    arrivals = form.arrivals(piece, setup, fixed=fixed)
    if arrivals is None:
        return None, position
    if position.columns and arrivals.columns != position.columns:
        raise InvalidInputError(
            f"{piece.path} has the columns {', '.join(arrivals.columns)}; the recording began "
            f"with {', '.join(position.columns)}. Every file must have the same."
        )
    if fixed:
        arrivals = with_fixed(arrivals, setup)
    last = float(arrivals.arrays["time"][-1])
    return arrivals, Position(position.files, arrivals.columns or position.columns, last)


def after(piece: Piece) -> FilePosition:
    """The position of a file once a piece of it was read."""
    read = piece.start + len(piece.body)
    with piece.path.open("rb") as file:
        known_by = digest(file.read(min(read, BEGINNING_BYTES)))
    now = seen(piece.path)
    said = now if now.size == read else UNSEEN  # only of use once all is read
    lines = piece.lines + piece.body.count(b"\n")
    return FilePosition(piece.path.name, read, lines, known_by, said)
