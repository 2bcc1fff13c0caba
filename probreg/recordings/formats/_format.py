"""What every format of recordings offers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import ClassVar

from probreg.recordings._reading import Reading
from probreg.recordings._setup import Setup


class RecordingFormat(ABC):
    """A form in which recordings are kept.

    Attributes
    ----------
    endings : tuple of str
        Of the names of files, by which they are recognised; none where content decides.
    """

    endings: ClassVar[tuple[str, ...]] = ()

    def recognises(self, path: Path) -> bool:
        """Whether a file, or a folder, is in this format."""
        return path.suffix.lower() in self.endings

    @abstractmethod
    def read(self, path: Path, setup: Setup, *, trust_units: bool = False) -> Reading:
        """Read a file, see `probreg.recordings.read`."""
