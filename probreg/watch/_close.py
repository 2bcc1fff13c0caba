"""The oldest open slice is closed: its reports go into tracks, beliefs and counts for good."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.motion.tracks import LiveTracks, merged
from probreg.noise import MixtureCounts
from probreg.posterior.tracks import Point
from probreg.posterior.tracks.steps import WRONG_ROWS, counts_of
from probreg.typing import IntArray
from probreg.watch._intake import with_rows
from probreg.watch._refine import CLOSING, NEW_WEIGHT, Frame, Refined
from probreg.watch.state import Noise, OpenReports, Tracks

REFUSED = 0.1  # weight below which a report says next to nothing of its target
RESTART = 5  # refusals in a row after which a track begins again


class Closed(NamedTuple):
    """Tracks and open reports without the oldest slice."""

    tracks: Tracks
    reports: OpenReports


def close(frame: Frame, refined: Refined, keep_s: float) -> Closed:
    """Run the oldest slice into the tracks; those that were not seen for `keep_s` are forgotten."""
    tracks, reports = frame.tracks, refined.reports
    if refined.tangent is not None:
        assert refined.live is not None
        at, group = refined.tangent.at, refined.tangent.group
        out = np.zeros(len(reports), dtype=bool)
        out[at.rows[group == CLOSING]] = True
        went = np.unique(at.equations.target[group == CLOSING])
        tracks = _with_states(tracks, refined.tangent.rows[went], went, refined.live)
        tracks, reports = _restarted(tracks, reports, ~out)
    live = merged(tracks.live, frame.scene.num_biases)
    tracks = Tracks(tracks.label, tracks.begun, tracks.seen, live)
    return Closed(*_remembered(tracks, reports, frame.end - keep_s))


def _with_states(tracks: Tracks, rows: IntArray, which: IntArray, live: LiveTracks) -> Tracks:
    begun = tracks.begun.copy()
    begun[rows] = True
    parts = [part.copy() for part in tracks.live]
    for part, new in zip(parts, live, strict=True):
        part[rows] = new[which]
    return Tracks(tracks.label, begun, tracks.seen, LiveTracks(*parts))


def _restarted(
    tracks: Tracks, reports: OpenReports, stay: np.ndarray
) -> tuple[Tracks, OpenReports]:
    """Open reports that stay; where the last ones of a track are refused they begin a new one."""
    reports = reports.take(stay)
    order = np.lexsort([reports.path.time, reports.track])
    track, bad = reports.track[order], reports.weight[order] < REFUSED
    end = np.flatnonzero(np.diff(track, append=-1))
    good_before = np.maximum.accumulate(np.where(bad, -1, np.arange(len(bad))))
    begin = np.append(-1, end[:-1])
    last_good = np.maximum(good_before[end], begin)
    run = end - last_good
    # a track that is nothing but refusals has nothing to leave behind
    lost = np.flatnonzero((run >= RESTART) & (tracks.begun[track[end]] | (last_good > begin)))
    if not lost.size:
        return tracks, reports
    given, weight = reports.track.copy(), reports.weight.copy()
    for k, (e, count) in enumerate(zip(end[lost].tolist(), run[lost].tolist(), strict=True)):
        own = order[e - count + 1 : e + 1]
        given[own], weight[own] = len(tracks.label) + k, NEW_WEIGHT
    tracks = with_rows(tracks, tracks.label[track[end[lost]]])
    seen = tracks.seen.copy()
    seen[-len(lost) :] = tracks.seen[track[end[lost]]]
    return Tracks(tracks.label, tracks.begun, seen, tracks.live), replace(
        reports, track=given, weight=weight
    )


def _remembered(tracks: Tracks, reports: OpenReports, since: float) -> tuple[Tracks, OpenReports]:
    """Without tracks that were last seen before `since`."""
    keep = tracks.seen >= since
    keep[reports.track] = True
    number = np.cumsum(keep) - 1
    return tracks.take(keep), replace(reports, track=number[reports.track])


def counted(frame: Frame, refined: Refined, fade: float) -> Noise:
    """Laws and shares of wrong identities with the closing slice, older counts faded."""
    noise = frame.noise
    if refined.tangent is None or refined.judged is None:
        return noise
    model, at = refined.tangent.model, refined.tangent.at
    weights = refined.reports.weight[at.rows]
    point = Point(at, weights, frame.density, noise.laws, noise.wrong, frame.constant_sd)
    among = (refined.tangent.group == CLOSING) & refined.judged.placed
    laws, wrong, counts = list(noise.laws), noise.wrong.copy(), list(noise.counts)
    missed, reports = fade * noise.missed, fade * noise.reports
    for s, law in enumerate(noise.laws):
        new, lost, n = counts_of(model, point, refined.judged, s, among)
        counts[s] = MixtureCounts(
            *(fade * a + b for a, b in zip(noise.counts[s], new, strict=True))
        )
        missed[s] += lost
        reports[s] += n
        m = len(frame.scene.seen.models[s].sigmas)
        laws[s] = law.refitted(counts[s], m, frozenset(noise.unknown[s]), noise.about[s])
        if wrong[s] > 0.0:
            about = WRONG_ROWS * noise.about_wrong[s]
            wrong[s] = (missed[s] + about) / (reports[s] + WRONG_ROWS)
    return replace(
        noise, laws=tuple(laws), wrong=wrong, counts=tuple(counts), missed=missed, reports=reports
    )
