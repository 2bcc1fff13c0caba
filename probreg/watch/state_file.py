"""The state of a watch in one file: complete or as it was before, refused where it is of another.

Arrays as numpy keeps them, and a text of JSON among them for all that is no array.
"""

from __future__ import annotations

import dataclasses
import io
import json
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import probreg
from probreg.errors import InvalidInputError
from probreg.recordings import Setup, setup_file
from probreg.recordings.files import replacing

FORMAT = 2
WORDS = "words"
MOST = 5  # differences that are named


def write(path: Path, arrays: Mapping[str, Any], words: Mapping[str, Any]) -> None:
    """Write a state aside, bring it to the disk, and put it in place.

    Parameters
    ----------
    path : Path
    arrays : mapping of str to ndarray
    words : mapping
        What JSON can say.

    Raises
    ------
    OSError
        A disk that is full; the state before is still there.
    """
    content = io.BytesIO()
    text = json.dumps(words, allow_nan=False).encode()
    every: dict[str, Any] = {WORDS: np.frombuffer(text, dtype=np.uint8), **arrays}
    np.savez(content, **every)
    with replacing(path) as part, part.open("wb") as file:
        file.write(content.getbuffer())
        file.flush()
        os.fsync(file.fileno())
    _sync_folder(path.parent)


def _sync_folder(folder: Path) -> None:
    """Bring the new name to the disk, where the system lets folders be opened."""
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def read(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arrays and words of a state.

    Raises
    ------
    InvalidInputError
        A file that cannot be read, or is none of these.
    """
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as content:
            arrays = {name: content[name] for name in content.files}
        words = json.loads(arrays.pop(WORDS).tobytes())
        return arrays, dict(words)
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile, TypeError):
        raise InvalidInputError(
            f"{path} is damaged, or no state of a watch; it is left as it is. Remove it, or begin "
            "in another folder."
        ) from None
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror}.") from None


def described(setup: Setup, settings: Any, others: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that a state depends on, one entry a fact."""
    told = setup_file.content(setup)
    sensors = {table["name"]: table for table in told.pop("sensor")}
    return {
        "format": FORMAT,
        "probreg": probreg.__version__,
        "sensors": list(sensors),
        **told,
        **{f"{key} of {name}": v for name, table in sensors.items() for key, v in table.items()},
        **dataclasses.asdict(settings),
        **others,
    }


def refuse_other(path: Path, there: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Refuse a state of another version, other sensors or other settings.

    Raises
    ------
    InvalidInputError
        With what differs.
    """
    wanted = json.loads(json.dumps(wanted))
    keys = [key for key in {**there, **wanted} if there.get(key) != wanted.get(key)]
    if keys:
        said = [f"{key} was {_said(there, key)}, and is {_said(wanted, key)}" for key in keys]
        more = f"; and {len(keys) - MOST} more" if len(keys) > MOST else ""
        raise InvalidInputError(
            f"{path} is the state of another watch: {'; '.join(said[:MOST])}{more}. It is left as "
            "it is. Go on with what it was begun with, or begin in another folder."
        )


def _said(facts: Mapping[str, Any], key: str) -> str:
    return json.dumps(facts[key], ensure_ascii=False) if key in facts else "not there"
