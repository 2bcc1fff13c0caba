"""Files that grow: one, which may be rotated, or all of a folder."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from probreg.errors import InvalidInputError
from probreg.recordings._setup import Setup
from probreg.recordings.formats import InPieces, known_formats
from probreg.recordings.growing._look import Look, after, growing_format, read_file, taken
from probreg.recordings.growing._position import FilePosition, Position, fits, seen

Placed = list[tuple[Path, FilePosition | None]]


@dataclass(frozen=True)
class GrowingFile:
    """One file; when it is renamed and begun anew, the rest of the old one is read first.

    Parameters
    ----------
    path : Path
    """

    path: Path
    ended: bool = dataclasses.field(default=False, init=False)

    def look(self, position: Position, setup: Setup, *, fixed: bool) -> Look:
        """The next piece, see `Source.look`."""
        form = growing_format(self.path)
        with _plain(self.path):
            there = [self.path] if self.path.is_file() else []
            if not there and not position.files:
                raise InvalidInputError(f"{self.path} cannot be read: there is no such file.")
            if not there:
                return Look(None, position, (f"{self.path} is gone; waiting for it",))
            placed = _placed(there, position, self._aside)
            if placed is None:
                raise _other(self.path, position)
            look = _next([(*one, form) for one in placed], position, setup, fixed)
        begun = [file for file in look.position.files if file.name == self.path.name]
        # what was rotated away is read to its end before the new file begins
        if begun and look.arrivals is not None:
            return look._replace(position=dataclasses.replace(look.position, files=tuple(begun)))
        return look

    def _aside(self) -> list[Path]:
        """Where the file may have been moved."""
        stem = self.path.stem
        return [p for p in self.path.parent.iterdir() if p.name.startswith(stem) and p.is_file()]


@dataclass(frozen=True)
class GrowingFolder:
    """A folder that gets files, each of which may still grow; hidden ones are passed over.

    Parameters
    ----------
    path : Path
    """

    path: Path
    ended: bool = dataclasses.field(default=False, init=False)

    def look(self, position: Position, setup: Setup, *, fixed: bool) -> Look:
        """The next piece, see `Source.look`; new files in the order in which they were written."""
        with _plain(self.path):
            there = [path for path in self.path.iterdir() if _is_ours(path)]
            placed = _placed(there, position, lambda: there)
            if placed is None:
                raise _other(self.path, position)
            files = [(path, known, growing_format(path)) for path, known in placed]
            return _next(files, position, setup, fixed)


@contextmanager
def _plain(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        name = error.filename or path
        raise InvalidInputError(f"{name} cannot be read: {error.strerror}.") from None


def _is_ours(path: Path) -> bool:
    forms = [form for form in known_formats() if isinstance(form, InPieces)]
    known = any(form.recognises(path) for form in forms)
    return known and not path.name.startswith(".") and path.is_file()


def _placed(
    there: Sequence[Path], position: Position, aside: Callable[[], Sequence[Path]]
) -> Placed | None:
    """Files that are there, each with how far it was read; None where one is another file now.

    Positions go with their file when it gets another name; those of files that are gone go.
    """
    by_name = {path.name: path for path in there}
    found: dict[Path, FilePosition] = {}
    lost = []
    for known in position.files:
        path = by_name.get(known.name)
        if path is not None and fits(path, known):
            found[path] = known
        else:
            lost.append(known)
    for known in lost:
        free = (path for path in aside() if path not in found)
        moved = next((path for path in free if fits(path, known)), None)
        if moved is not None:
            found[moved] = dataclasses.replace(known, name=moved.name)
        elif known.name in by_name:
            return None
    new = sorted(
        (path for path in there if path not in found), key=lambda p: (seen(p).changed_ns, p.name)
    )
    return [*found.items(), *((path, None) for path in new)]


def _next(
    files: Sequence[tuple[Path, FilePosition | None, InPieces]],
    position: Position,
    setup: Setup,
    fixed: bool,
) -> Look:
    """The first piece that there is, in the order of the files."""
    kept = tuple(known for _, known, _ in files if known is not None)
    position = dataclasses.replace(position, files=kept)
    waiting = []
    for path, known, form in files:
        piece = read_file(path, form, known, position.last)
        if piece is None:
            waiting += _unfinished(path, known)
            continue
        arrivals, position = taken(piece, form, position, setup, fixed=fixed)
        others = (one for one in kept if one is not known)
        return Look(arrivals, dataclasses.replace(position, files=(*others, after(piece))))
    return Look(None, position, tuple(waiting))


def _unfinished(path: Path, known: FilePosition | None) -> list[str]:
    """What is said of a file whose end is not complete."""
    rest = seen(path).size - (0 if known is None else known.read)
    return [f"{path} ends in {rest} bytes that are not complete; waiting for the rest"] * bool(rest)


def _other(path: Path, position: Position) -> InvalidInputError:
    names = ", ".join(f"{file.name} ({file.read} bytes)" for file in position.files[-3:])
    return InvalidInputError(
        f"{path} is not what was read before ({names}): a file became shorter or was written "
        "anew, and the old one is nowhere beside it. Bring it back, rotate files by renaming "
        "them, or begin afresh in another folder of results."
    )
