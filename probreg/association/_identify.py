"""Identities for reports that have none."""

from __future__ import annotations

import dataclasses

from probreg.association._labelled import nearest_labelled
from probreg.association._placed import Placed, place
from probreg.association._tracks import common_tracks
from probreg.errors import InvalidInputError
from probreg.recordings import UNKNOWN, Recording, Setup
from probreg.typing import FloatArray


def associate(recording: Recording, setup: Setup, theta: FloatArray | None = None) -> Recording:
    """Fill in identities where the recording has none.

    Where some reports carry an identity (of a reference, or of tracks that were identified),
    the others are given to the nearest of these targets at their time. Where none does, each
    sensor's reports are linked into tracks, and tracks of different sensors are matched.

    Parameters
    ----------
    recording : Recording
    setup : Setup
    theta : ndarray, shape (p,), optional
        The biases, if they are known; otherwise gates are widened by their priors.

    Returns
    -------
    Recording
        With identities; reports that fit no target keep none.

    Raises
    ------
    InvalidInputError
        Nothing that can be associated.
    """
    missing = recording.target == UNKNOWN
    if not missing.any():
        return recording
    placed: Placed = place(recording, setup, theta)
    if missing.all():
        target = common_tracks(recording, setup, placed)
        if not all(sensor.gives_position for sensor in recording.sensors):
            target = nearest_labelled(recording, setup, placed, target)
        labels = tuple(f"track{k}" for k in range(int(target.max(initial=-1)) + 1))
        found = dataclasses.replace(recording, target=target, labels=labels)
    else:
        target = nearest_labelled(recording, setup, placed, recording.target)
        found = dataclasses.replace(recording, target=target)
    if not (found.target != UNKNOWN).any():
        raise InvalidInputError(
            f"no report could be associated within gate_m = {setup.gate_m:g} m; widen it, or check "
            "the positions of the sensors."
        )
    return found
