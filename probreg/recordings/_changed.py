"""Corrected recordings as files of the form they came in, and back."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np

from probreg.recordings._reading import Reading
from probreg.recordings._recording import Recording
from probreg.recordings._setup import Setup
from probreg.recordings.bias_paths import Biases


def write_changed(
    path: str | Path,
    source: Reading,
    setup: Setup,
    theta: Biases,
    change: Callable[[Recording, Setup, Biases], Recording],
) -> None:
    """Write a recording, corrected or restored by theta, in the form it came in.

    Parameters
    ----------
    path : str or Path
        With the source's `changed_ending`.
    source : Reading
    setup : Setup
    theta : ndarray, shape (p,), or BiasPaths
    change : callable
        `correct` or `restore`.

    Raises
    ------
    InvalidInputError
        A source that is no longer as it was read, a path that cannot be written.
    """
    recording = source.recording
    # reports carry their number through the change, which sorts them by the new time
    numbered = dataclasses.replace(recording, target=np.arange(len(recording)), labels=())
    moved = change(numbered, setup, theta)
    order = moved.target
    named = dataclasses.replace(moved, target=recording.target[order], labels=recording.labels)
    if source.writer is None:
        from probreg.recordings import new_table  # loads pandas

        new_table.create(path, named, setup)
    else:
        source.writer(Path(path), named, order, setup)
