"""Where a watch stands: kept in a file after every slice, and taken up from there."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from probreg.errors import InvalidInputError
from probreg.recordings import Setup, growing
from probreg.recordings.growing import Buffer, Position
from probreg.watch import history, state_file
from probreg.watch.history import History
from probreg.watch.task import Task

STATE, LOCK = "state.npz", "lock"


@dataclass(frozen=True, eq=False)
class Going:
    """Where a watch stands.

    Attributes
    ----------
    setup : Setup
        Completed by the first reports.
    state : WatchState or None
        None before the first minutes are there.
    buffer : Buffer
    position : Position
    journal : int
        Bytes.
    wrong : tuple of str
        Sensors whose clocks are wrong.
    late_kinds : tuple of str
        Kinds of reports that have appeared since the first minutes.
    past : History
    """

    setup: Setup
    state: Any = None
    buffer: Buffer = field(default_factory=Buffer)
    position: Position = field(default_factory=Position)
    journal: int = 0
    wrong: tuple[str, ...] = ()
    late_kinds: tuple[str, ...] = ()
    past: History = field(default_factory=History)


def save(task: Task, going: Going) -> None:
    """Write the state aside and put it in place of the one before."""
    parts = {
        "engine": task.engine.to_arrays(going.state),
        "buffer": going.buffer.to_arrays(),
        "past": history.to_arrays(going.past),
    }
    arrays = {f"{part}.{name}": a for part, own in parts.items() for name, a in own.items()}
    words = {
        "task": task.described,
        "setup": growing.said(task.setup, going.setup),
        "position": going.position.to_json(),
        "journal": going.journal,
        "wrong": going.wrong,
        "late_kinds": going.late_kinds,
        "alarms": going.past.alarms,
    }
    state_file.write(task.folder / STATE, arrays, words)


def resumed(task: Task) -> Going:
    """Where the state in the folder says that the watch stands; at the start without one.

    Raises
    ------
    InvalidInputError
        A state that is damaged, of another version, of other sensors or other settings.
    """
    path = task.folder / STATE
    for part in task.folder.glob(f"{STATE}.*.part"):  # of an end while it was written
        part.unlink(missing_ok=True)
    if not path.exists():
        return Going(task.setup)
    arrays, words = state_file.read(path)
    state_file.refuse_other(path, words.get("task", {}), task.described)
    setup = growing.completed(task.setup, words["setup"])
    return Going(
        setup,
        task.engine.from_arrays(_own(arrays, "engine"), setup, task.settings),
        Buffer.from_arrays(_own(arrays, "buffer")),
        Position.from_json(words["position"]),
        words["journal"],
        tuple(words["wrong"]),
        tuple(words["late_kinds"]),
        history.from_arrays(_own(arrays, "past"), tuple(words["alarms"])),
    )


def _own(arrays: Mapping[str, Any], part: str) -> dict[str, Any]:
    start = f"{part}."
    return {name.removeprefix(start): a for name, a in arrays.items() if name.startswith(start)}


@contextmanager
def only_one(folder: Path) -> Iterator[None]:
    """Hold a lock on the folder, which the system takes back whatever ends the process.

    Raises
    ------
    InvalidInputError
        Another watch has it.
    """
    handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        _lock(handle, folder)
        yield
    finally:
        os.close(handle)


def _lock(handle: int, folder: Path) -> None:
    try:
        import fcntl
    except ImportError:  # systems without
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise InvalidInputError(
            f"another watch writes into {folder}; end it, or name another folder."
        ) from None
