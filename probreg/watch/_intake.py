"""New reports are taken in: whose they are, where their targets are, and which come too late."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.problems.recording.first_guess import first_guess
from probreg.problems.recording.track_reports import PathPoints
from probreg.recordings import Recording, Setup
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.watch._refine import NEW_WEIGHT, Frame, track_reports
from probreg.watch._scene import kinds_of, labels_of, platform
from probreg.watch.state import OpenReports, Tracks

_APART_S = 1e6  # between tracks on one axis of time


class Intake(NamedTuple):
    """Open reports and tracks with the new ones, and how many could not be used.

    Attributes
    ----------
    reports : OpenReports
    tracks : Tracks
    used : ndarray of int, shape (models,)
    late, unplaced : int
    """

    reports: OpenReports
    tracks: Tracks
    used: IntArray
    late: int
    unplaced: int


def take_in(
    frame: Frame, reports: OpenReports, setup: Setup, new: Recording | None, opened: float
) -> Intake:
    """Open reports joined by new ones, unless these are from before the time `opened`."""
    models = len(frame.scene.seen.models)
    if new is None or not len(new):
        return Intake(reports, frame.tracks, np.zeros(models, dtype=np.int64), 0, 0)
    kind, label = kinds_of(frame.scene, new), labels_of(new)
    known = (kind >= 0) & (label != "") & np.isfinite(new.values).any(axis=1)
    late = known & (_corrected(frame, kind, new.time) < opened)
    rows = np.flatnonzero(known & ~late)
    tracks, row = _rows_of(frame.tracks, label[rows], new.time[rows])
    own, turn = platform(frame.scene, setup, new)
    width = reports.values.shape[1]
    values = np.full((len(new), max(width, new.values.shape[1])), np.nan)
    values[:, : new.values.shape[1]] = new.values
    added = OpenReports(
        row, kind[rows], new.time[rows], values[rows, :width], own[rows], turn[rows],
        np.full(len(rows), NEW_WEIGHT),
        PathPoints(new.time[rows], *(np.full((len(rows), frame.scene.dim), np.nan),) * 2),
    )  # fmt: skip
    added, placed = _placed(frame._replace(tracks=tracks), reports, added)
    used = np.bincount(added.kind, minlength=models)
    lost = int((~known).sum() + (~placed).sum())
    return Intake(reports.joined(added), tracks, used, int(late.sum()), lost)


def _corrected(frame: Frame, kind: IntArray, time: FloatArray) -> FloatArray:
    """Time by the clocks corrected."""
    delay = [sum(term.stamp * frame.theta[c] for c, term in model.terms)
             for model in frame.scene.seen.models]  # fmt: skip
    return np.asarray(time - np.append(delay, 0.0)[kind])


def _rows_of(tracks: Tracks, label: np.ndarray, time: FloatArray) -> tuple[Tracks, IntArray]:
    """Rows (n,) of the tracks that reports go to, new ones where there are none."""
    number = {name: k for k, name in enumerate(tracks.label.tolist())}
    fresh = [name for name in dict.fromkeys(label.tolist()) if name not in number]
    number |= {name: len(tracks.label) + k for k, name in enumerate(fresh)}
    row = np.array([number[name] for name in label.tolist()], dtype=np.int64)
    tracks = with_rows(tracks, np.array(fresh, dtype=str))
    seen = tracks.seen.copy()
    np.maximum.at(seen, row, time)
    return Tracks(tracks.label, tracks.begun, seen, tracks.live), row


def with_rows(tracks: Tracks, label: np.ndarray) -> Tracks:
    """With new tracks of which nothing is known."""
    n = len(label)

    def longer(part: FloatArray) -> FloatArray:
        return np.concatenate([part, np.zeros((n, *part.shape[1:]))])

    live = tracks.live._replace(**{k: longer(v) for k, v in tracks.live._asdict().items()})
    return Tracks(
        np.concatenate([tracks.label, label]),
        np.append(tracks.begun, np.zeros(n, dtype=bool)),
        np.append(tracks.seen, np.full(n, -np.inf)),
        live,
    )


def _placed(
    frame: Frame, reports: OpenReports, added: OpenReports
) -> tuple[OpenReports, BoolArray]:
    """Where the targets of new reports are; those that nothing places are left out."""
    d, tracks = frame.scene.dim, frame.tracks
    known = np.flatnonzero(tracks.begun)
    track = np.concatenate([reports.track, known])
    path = PathPoints(
        np.concatenate([reports.path.time, tracks.live.time[known]]),
        np.concatenate([reports.path.position, tracks.live.mean[known, :d]]),
        np.concatenate([reports.path.velocity, tracks.live.mean[known, d : 2 * d]]),
    )
    nearest = _nearest((track, path.time), (added.track, added.time), frame.end)
    found = nearest >= 0
    new = np.flatnonzero(~found)
    position, velocity = np.zeros((len(added), d)), np.zeros((len(added), d))
    time = added.time.copy()
    position[found], velocity[found], time[found] = (
        path.position[nearest[found]], path.velocity[nearest[found]], path.time[nearest[found]],
    )  # fmt: skip
    if new.size:
        _, target = np.unique(added.track[new], return_inverse=True)
        alone = track_reports(frame, added.take(new), target)
        position[new] = first_guess(alone, frame.scene.height_m, strict=False).position
    good = np.asarray(np.isfinite(position).all(axis=1))
    return replace(added, path=PathPoints(time, position, velocity)).take(good), good


def _nearest(
    known: tuple[IntArray, FloatArray], asked: tuple[IntArray, FloatArray], end: float
) -> IntArray:
    """Which of the known points (track, time) is of the track asked and just before, else after.

    -1 where there is none.
    """
    if not len(known[0]):
        return np.full(len(asked[0]), -1)
    place, wanted = (track * _APART_S + (time - end) for track, time in (known, asked))
    order = np.argsort(place, kind="stable")
    after = np.searchsorted(place[order], wanted, side="right")
    found = np.full(len(wanted), -1)
    for at in (np.minimum(after, len(order) - 1), np.maximum(after - 1, 0)):
        own = order[at]
        found = np.where(known[0][own] == asked[0], own, found)
    return found
