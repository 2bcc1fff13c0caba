"""Formats of recordings, one a module: a module with one public class is found by `read`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TypeVar

from probreg.discovery import public_classes
from probreg.errors import InvalidInputError
from probreg.recordings._reading import Reading
from probreg.recordings._setup import Setup
from probreg.recordings.formats._format import RecordingFormat
from probreg.recordings.formats._in_pieces import InPieces

__all__ = ["InPieces", "RecordingFormat", "choose", "known_formats", "read"]

F = TypeVar("F", bound=RecordingFormat)


@cache
def known_formats() -> tuple[RecordingFormat, ...]:
    """Every format that recordings are read from."""
    return tuple(owner() for owner in public_classes(sys.modules[__name__]).values())


def choose(path: Path, known: Sequence[F]) -> F:
    """The one of some formats that a file is in.

    Raises
    ------
    InvalidInputError
        None of them.
    """
    found = next((form for form in known if form.recognises(path)), None)
    if found is None:
        endings = ", ".join(ending for form in known for ending in form.endings)
        raise InvalidInputError(f"{path} ends with none of {endings}; convert it.")
    return found


def read(path: str | Path, setup: Setup, *, trust_units: bool = False) -> Reading:
    """Read a recording in whatever format it is.

    Parameters
    ----------
    path : str or Path
        A table (.csv or .parquet, see `probreg.recordings.table`), ASTERIX (.ast) whose sources
        the setup names, or the folder of an Autoferry scenario.
    setup : Setup
    trust_units : bool
        Whether to leave out the checks for radians, kilometres and milliseconds by the look of
        the numbers, in formats in which these could be.

    Returns
    -------
    Reading

    Raises
    ------
    InvalidInputError
        A format not known; what cannot be meant, with its place in the file and what to do.
    """
    path = Path(path)
    return choose(path, known_formats()).read(path, setup, trust_units=trust_units)
