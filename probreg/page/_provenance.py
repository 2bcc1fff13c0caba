"""What a result was made of and with."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import probreg

PACKAGES = ("numpy", "scipy", "numba", "arviz", "pandas", "pyarrow")


@dataclass(frozen=True)
class Provenance:
    """Where a result came from.

    Parameters
    ----------
    command : str
        What was called, such as "register".
    seed : int, optional
    settings : mapping
        Every setting, in words that JSON knows.
    inputs : mapping of str to str
        SHA-256 of each input file, by its name.
    started : str
        ISO 8601.
    notes : tuple of str
        Remarks of the readers of the files.
    """

    command: str = "register"
    seed: int | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    inputs: Mapping[str, str] = field(default_factory=dict)
    started: str = ""
    notes: tuple[str, ...] = ()


def checksum(path: str | Path) -> str:
    """SHA-256 of a file."""
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def versions() -> dict[str, str]:
    """Versions of the program and of what its numbers depend on."""
    found = {"probreg": probreg.__version__, "python": platform.python_version()}
    return found | {name: version(name) for name in PACKAGES}
