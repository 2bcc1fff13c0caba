"""A recording that comes through standard input: lines of a CSV table."""

from __future__ import annotations

import dataclasses
import queue
import threading
from pathlib import Path
from typing import IO

from probreg.errors import InvalidInputError
from probreg.recordings._arrivals import Piece
from probreg.recordings._setup import Setup
from probreg.recordings.formats import InPieces
from probreg.recordings.formats.csv import Csv
from probreg.recordings.growing._look import Look, taken
from probreg.recordings.growing._position import BEGINNING_BYTES, FilePosition, Position, digest

NAME = "standard input"
AT_ONCE, AHEAD = 1 << 20, 8  # bytes of a reading, and readings before they are asked for


class GrowingInput:
    """A stream that cannot be read twice.

    After an end, a stream that begins with the same bytes is taken for the same one from its
    beginning: what was read is passed over. Any other goes on after its line of names.

    Parameters
    ----------
    stream : binary file
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self._form: InPieces = Csv()
        self._queue: queue.Queue[bytes] = queue.Queue(AHEAD)
        self._pending = self._first = self._head = b""
        self._closed, self._skip, self._read, self._lines = False, 0, 0, 1
        # reading waits: in a thread of its own, so that the watch does not
        threading.Thread(target=self._fill, args=(stream,), daemon=True).start()

    def _fill(self, stream: IO[bytes]) -> None:
        read = getattr(stream, "read1", stream.read)
        while content := read(AT_ONCE):
            self._queue.put(content)
        self._queue.put(b"")

    @property
    def ended(self) -> bool:
        """Whether nothing more can come."""
        return self._closed and not self._form.complete_length(self._pending)

    def look(self, position: Position, setup: Setup, *, fixed: bool) -> Look:
        """The next piece, see `Source.look`."""
        self._receive()
        if not self._head and not self._begin(position):
            return Look(None, position)
        passed = min(self._skip, len(self._pending))
        self._skip, self._pending = self._skip - passed, self._pending[passed:]
        length = self._form.complete_length(self._pending)
        if self._skip or not length:
            return Look(None, position)
        body, self._pending = self._pending[:length], self._pending[length:]
        piece = Piece(Path(NAME), self._head, body, self._read, self._lines, position.last)
        arrivals, position = taken(piece, self._form, position, setup, fixed=fixed)
        self._read, self._lines = self._read + length, self._lines + body.count(b"\n")
        self._first = (self._first + body)[:BEGINNING_BYTES]
        file = FilePosition(NAME, self._read, self._lines, digest(self._first))
        return Look(arrivals, dataclasses.replace(position, files=(file,)))

    def _receive(self) -> None:
        """Take what has come; not more than a piece, so that memory stays bounded."""
        while not self._closed and len(self._pending) < AT_ONCE:
            try:
                content = self._queue.get_nowait()
            except queue.Empty:
                return
            self._closed = not content
            self._pending += content

    def _begin(self, position: Position) -> bool:
        """Find the line of names, and whether the stream is one that was read before."""
        known = position.files[0] if position.files else FilePosition(NAME, 0, 0, "")
        length = self._form.head_length(self._pending)
        if length is None or (len(self._pending) < known.beginning and not self._closed):
            if self._closed:
                raise InvalidInputError(f"{NAME} ended before a line with the names of columns.")
            return False
        self._head = self._pending[:length]
        if known.read and digest(self._pending[: known.beginning]) == known.known_by:
            self._first = self._pending[: known.beginning]
            self._skip, self._read, self._lines = known.read, known.read, known.lines
            return True
        self._pending = self._pending[length:]
        self._first, self._read, self._lines = self._head, length, 1
        return True
