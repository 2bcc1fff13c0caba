"""Identities for reports that have none."""

from __future__ import annotations

import dataclasses

from probreg.association._labelled import nearest_labelled
from probreg.association._placed import place
from probreg.association._tracks import common_tracks
from probreg.errors import InvalidInputError
from probreg.recordings import UNKNOWN, Biases, Recording, Setup


def associate(recording: Recording, setup: Setup, theta: Biases | None = None) -> Recording:
    """Fill in identities where the recording has none.

    Where some reports carry an identity (of a reference, or of tracks that were identified),
    the others are given to the nearest of these targets at their time. Where none does, each
    sensor's reports are linked into tracks, and tracks of different sensors are matched. Heights
    that came with a report have its identity, and are never associated by themselves.

    Parameters
    ----------
    recording : Recording
    setup : Setup
    theta : ndarray, shape (p,), or BiasPaths, optional
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
    placed = place(recording, setup, theta)
    target, labels = recording.target, recording.labels
    if missing.all():
        target = common_tracks(placed, setup)
        labels = tuple(f"track{k}" for k in range(int(target.max(initial=UNKNOWN)) + 1))
    if not missing.all() or placed.reports.size:
        target = nearest_labelled(placed, target)
    if recording.beside is not None:
        target = target[recording.beside]
    if not (target != UNKNOWN).any():
        raise InvalidInputError(
            f"no report could be associated within gate_m = {setup.gate_m:g} m; widen it, or check "
            "the positions of the sensors."
        )
    return dataclasses.replace(recording, target=target, labels=labels)
