"""What is to be watched, by what, and until when."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from probreg.recordings import Recording, Setup
from probreg.recordings.growing import Source
from probreg.watch import state_file


class Engine(Protocol):
    """What computes: `probreg.watch`, or what a test puts in its place."""

    def begin(
        self, recording: Recording, setup: Setup, settings: Any, rng: np.random.Generator
    ) -> Any:
        """State after the first minutes."""

    def advance(self, state: Any, reports: Recording | None, until: float) -> tuple[Any, Any]:
        """State and result one slice later."""

    def to_arrays(self, state: Any) -> dict[str, Any]:
        """Arrays that say it all."""

    def from_arrays(self, arrays: dict[str, Any], setup: Setup, settings: Any) -> Any:
        """The state of such arrays."""


class Clock(NamedTuple):
    """What time it is, and how to wait."""

    monotonic: Callable[[], float] = time.monotonic
    posix: Callable[[], float] = time.time
    sleep: Callable[[float], None] = time.sleep


class Ends(NamedTuple):
    """When a watch ends by itself.

    Attributes
    ----------
    until : float or None
        Time of the recording, seconds; of POSIX time also by the clock of the computer.
    patience_s : float or None
        So long without anything new.
    """

    until: float | None = None
    patience_s: float | None = None


class Talk(NamedTuple):
    """Who is told, and who may ask to end.

    Attributes
    ----------
    said : callable
        Takes what is to be said while there is nothing to do.
    asked : callable
        Called again and again; raises KeyboardInterrupt where the end was asked for.
    """

    said: Callable[[str], None] = lambda text: None
    asked: Callable[[], None] = lambda: None


class Task(NamedTuple):
    """What is to be watched, and how.

    Attributes
    ----------
    source : Source
    setup : Setup
    folder : Path
        In which state and journal are; it is there.
    engine : Engine
    settings : WatchSettings
    start_s : float
        Length of the batch at the start.
    seed : int
    trust_units : bool
    ends : Ends
    talk : Talk
    clock : Clock
    """

    source: Source
    setup: Setup
    folder: Path
    engine: Engine
    settings: Any
    start_s: float = 300.0
    seed: int = 0
    trust_units: bool = False
    ends: Ends = Ends()
    talk: Talk = Talk()
    clock: Clock = Clock()

    @property
    def described(self) -> dict[str, Any]:
        """What a state of this task depends on."""
        others = {"start_s": self.start_s, "seed": self.seed}
        return state_file.described(self.setup, self.settings, others)
