"""What every file format gives."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.typing import IntArray


@dataclass(frozen=True, eq=False)
class Reading:
    """What a file gave.

    Attributes
    ----------
    path : Path
    recording : Recording
    notes : tuple of str
        What the reader of results should know: columns not used, rows put in order.
    """

    path: Path
    recording: Recording
    notes: tuple[str, ...]

    def row_name(self, report: int) -> str:
        """What the reader of the file knows a report by, as errors name it too."""
        return f"report {report}"

    @property
    def changed_ending(self) -> str:
        """Ending of the file that `write_changed` writes."""
        return ".csv"

    def write_changed(
        self, path: str | Path, changed: Recording, order: IntArray, setup: Setup
    ) -> None:
        """Write what the recording became; of formats that are only read, as a new table.

        Parameters
        ----------
        path : str or Path
        changed : Recording
            Changed in time and values.
        order : ndarray of int, shape (n,)
            Which report of the reading each report of `changed` is.
        setup : Setup
            With which it was read.

        Raises
        ------
        InvalidInputError
            A path that cannot be written, or has another ending.
        """
        from probreg.recordings import new_table  # loads pandas

        new_table.create(path, changed, setup)
