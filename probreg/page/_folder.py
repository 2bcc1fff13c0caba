"""A folder of results that is complete or as it was before."""

from __future__ import annotations

import json
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from probreg.errors import InvalidInputError

MANIFEST = "manifest.json"


@contextmanager
def result_folder(folder: str | Path, command: str, *, overwrite: bool = False) -> Iterator[Path]:
    """Give a temporary folder; its files move to `folder` when all went well.

    Files of an earlier result are replaced; those of another hand stay. Whatever goes wrong,
    an interrupt included, leaves `folder` as it was.

    Parameters
    ----------
    folder : str or Path
        Not there, empty, or with an earlier result of the same command.
    command : str
        As in the manifest.
    overwrite : bool
        Whether other files may be there.

    Raises
    ------
    InvalidInputError
        A folder with other files, or that cannot be written.
    """
    folder = Path(folder).absolute()
    _refuse_foreign(folder, command, overwrite)
    above = next(parent for parent in folder.parents if parent.is_dir())
    part = above / f".{folder.name}.{secrets.token_hex(4)}.part"
    try:  # before the folder is there, so that no interrupt finds it unguarded
        _make(part, folder)
        yield part
        part.chmod(0o777 & ~_umask())
        _move(part, folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def own_folder(folder: str | Path, command: str) -> Path:
    """A folder in which a command keeps its files while it runs; made if not there.

    Parameters
    ----------
    folder : str or Path
        Not there, empty, or with earlier files of the same command.
    command : str
        As in the manifest.

    Raises
    ------
    InvalidInputError
        A folder with other files, or that cannot be written.
    """
    folder = Path(folder).absolute()
    _refuse_foreign(folder, command, overwrite=False)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInputError(f"{folder} cannot be made: {error.strerror}.") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InvalidInputError(f"{folder} cannot be written; change its permissions.")
    return folder


def _make(part: Path, folder: Path) -> None:
    if folder.exists() and not os.access(folder, os.W_OK | os.X_OK):
        raise InvalidInputError(f"{folder} cannot be written; change its permissions.")
    try:
        part.mkdir(mode=0o700)
    except OSError as error:
        raise InvalidInputError(f"{folder} cannot be made: {error.strerror}.") from None


def _refuse_foreign(folder: Path, command: str, overwrite: bool) -> None:
    if folder.exists() and not folder.is_dir():
        raise InvalidInputError(f"{folder} is a file; name a folder.")
    if overwrite or not folder.exists() or not any(folder.iterdir()):
        return
    if _command(folder / MANIFEST) != command:
        raise InvalidInputError(
            f"{folder} is not empty and holds no result of `probreg {command}`; name another "
            "folder, or allow to overwrite (--overwrite)."
        )


def _command(manifest: Path) -> str | None:
    """The command whose result lies in a folder, None where none does."""
    try:
        content = json.loads(manifest.read_text(encoding="utf-8"))
        return str(content["command"]) if content["program"] == "probreg" else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _move(part: Path, folder: Path) -> None:
    """Move a complete result to its place: at once where nothing is, else file by file."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    if not folder.exists():
        os.rename(part, folder)
        return
    stale = _outputs(folder / MANIFEST)
    # the manifest goes last: while it is the old one, the old result is what it vouches for
    for file in sorted(part.iterdir(), key=lambda path: path.name == MANIFEST):
        os.replace(file, folder / file.name)
        stale.discard(file.name)
    for name in stale:
        (folder / name).unlink(missing_ok=True)


def _outputs(manifest: Path) -> set[str]:
    """Names of the files of an earlier result."""
    if _command(manifest) is None:
        return set()
    outputs = json.loads(manifest.read_text(encoding="utf-8")).get("outputs", {})
    return {Path(name).name for name in outputs}
