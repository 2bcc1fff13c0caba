"""What formats offer whose files are read while they grow."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from probreg.recordings._arrivals import Arrivals, Piece
from probreg.recordings._setup import Setup
from probreg.recordings.formats._format import RecordingFormat


class InPieces(RecordingFormat):
    """A format of which complete items can be told from one that is still being written.

    Attributes
    ----------
    piece_bytes : int or None
        Most that is read at once; None of formats whose files are complete or of no use.
    """

    piece_bytes: ClassVar[int | None] = None

    def head_length(self, content: bytes) -> int | None:
        """Bytes of what stands once at the beginning of a file; None while it is incomplete."""
        return 0

    @abstractmethod
    def complete_length(self, body: bytes) -> int:
        """Bytes of the complete items at the start of what follows the head."""

    @abstractmethod
    def arrivals(self, piece: Piece, setup: Setup, *, fixed: bool) -> Arrivals | None:
        """Reports of a piece, None where it has none.

        Parameters
        ----------
        piece : Piece
        setup : Setup
        fixed : bool
            Whether places of sensors are known and stay.

        Raises
        ------
        InvalidInputError
            What cannot be meant, with its place in the file.
        """
