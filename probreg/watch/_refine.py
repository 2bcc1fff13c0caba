"""Weights and paths of the open reports, and what they say of the biases."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from probreg.motion.tracks import (
    LiveTracks,
    SmoothedTracks,
    Sums,
    TrackEquations,
    TrackMotion,
    carried,
    follow_tracks,
    smooth_tracks,
)
from probreg.posterior.tracks import Judgement, Point, TrackModel, judge
from probreg.posterior.tracks.steps import STEADY
from probreg.prior import GaussianPrior
from probreg.problems.recording.first_guess import first_guess
from probreg.problems.recording.track_reports import PathPoints, TrackLinearisation, TrackReports
from probreg.typing import FloatArray, IntArray
from probreg.watch._filters import whole_belief
from probreg.watch._scene import Scene
from probreg.watch.state import Filters, Noise, OpenReports, Tracks

NEW_WEIGHT = 0.01  # of reports that no one has judged
LONE_WEIGHT = 1e-5  # of those that no other places: judged again as if new, they pull at nothing
ROUNDS = 3
WIDENED = (30.0, 30.0, 10.0, 10.0, 3.0, 3.0, 1.0, 1.0)  # noise of tracks that are young
CLOSING, OPEN, NEWEST = 0, 1, 2  # groups of reports


class Frame(NamedTuple):
    """What stays as it is while the open reports are refined.

    Attributes
    ----------
    scene : Scene
    theta : ndarray, shape (p,)
    density : float
    area_m2 : float
    constant_sd : ndarray, shape (c,)
    noise : Noise
    tracks : Tracks
    window : int
    open_slices : int
    slice_s : float
    end : float
        Of the newest slice.
    """

    scene: Scene
    theta: FloatArray
    density: float
    area_m2: float
    constant_sd: FloatArray
    noise: Noise
    tracks: Tracks
    window: int
    open_slices: int
    slice_s: float
    end: float


class Tangent(NamedTuple):
    """Open reports at a tangent, each with its knot and group, and how their tracks began.

    Attributes
    ----------
    model : TrackModel
    at : TrackLinearisation
    equations : TrackEquations
        Of the tangent, with a column for every bias at every knot.
    rows : ndarray of int
        Of the tracks that have open reports.
    start : TrackMotion
    columns : ndarray
    knot, group : ndarray of int, shape (n,)
        In the order of the tangent.
    """

    model: TrackModel
    at: TrackLinearisation
    equations: TrackEquations
    rows: IntArray
    start: TrackMotion
    columns: FloatArray
    knot: IntArray
    group: IntArray


class Refined(NamedTuple):
    """Open reports after refinement.

    Attributes
    ----------
    reports : OpenReports
    tangent : Tangent or None
        None without reports.
    judged : Judgement or None
        In the order of the tangent.
    sums : Sums
        Of the three groups.
    live : LiveTracks or None
        After the closing slice.
    smoothed : SmoothedTracks or None
    weights : ndarray, shape (n,), or None
        With which they were smoothed, in the order of the tangent.
    """

    reports: OpenReports
    tangent: Tangent | None
    judged: Judgement | None
    sums: Sums
    live: LiveTracks | None
    smoothed: SmoothedTracks | None = None
    weights: FloatArray | None = None

    @property
    def information(self) -> tuple[FloatArray, FloatArray]:
        """J and eta of all open reports."""
        return self.sums.J.sum(axis=0), self.sums.eta.sum(axis=0)


class Judged(NamedTuple):
    """Reports with new weights and paths, and what these follow from.

    Attributes
    ----------
    reports : OpenReports
    judged : Judgement
    smoothed : SmoothedTracks
    weights : ndarray, shape (n,)
        Those before, in the order of the tangent.
    steady : PathPoints or None
        Smoother paths where terms vary.
    """

    reports: OpenReports
    judged: Judgement
    smoothed: SmoothedTracks
    weights: FloatArray
    steady: PathPoints | None


def refine(frame: Frame, reports: OpenReports, filters: Filters, delta: FloatArray) -> Refined:
    """Judge the open reports given each other, at the biases that follow from them.

    `delta` (W p,) are the biases at the knots to begin with.
    """
    C = len(delta)
    if not len(reports):
        empty = Sums(np.zeros((3, C, C)), np.zeros((3, C)), np.zeros(3))
        return Refined(reports, None, None, empty, None)
    hopeful = np.where(reports.weight == LONE_WEIGHT, NEW_WEIGHT, reports.weight)
    reports = _with_young(frame, replace(reports, weight=hopeful), delta)
    tangent = tangent_of(frame, reports)
    first = _judged(frame, tangent, reports, delta)
    reports = first.reports
    tangent = tangent_of(frame, reports, first.steady)
    J, eta = (part.sum(axis=0) for part in follow_open(tangent, reports)[0][:2])
    delta, _ = whole_belief(filters, J, eta)
    for _ in range(ROUNDS - 1):
        last = _judged(frame, tangent, reports, delta)
        reports = last.reports
    sums, live = follow_open(tangent, reports)
    return Refined(reports, tangent, last.judged, sums, live, last.smoothed, last.weights)


def _with_young(frame: Frame, reports: OpenReports, delta: FloatArray) -> OpenReports:
    """Tracks without closed reports judged afresh, from wide noise on: the first may be wrong."""
    young = np.flatnonzero(~frame.tracks.begun[reports.track])
    if not young.size:
        return reports
    own = reports.take(young)
    _, target = np.unique(own.track, return_inverse=True)
    guess = first_guess(track_reports(frame, own, target), frame.scene.height_m, strict=False)
    placed = np.asarray(np.isfinite(guess.position).all(axis=1))
    path = PathPoints(*(np.where(placed if a.ndim == 1 else placed[:, None], a, b)
                        for a, b in zip(guess, own.path, strict=True)))  # fmt: skip
    own = replace(own, weight=np.full(len(own), WIDENED[0] ** -2.0), path=path)
    tangent = tangent_of(frame, own)
    for factor in WIDENED:
        own = _judged(frame, tangent, own, delta, factor).reports
    weight, whole = reports.weight.copy(), [part.copy() for part in reports.path]
    weight[young] = np.where(own.weight == LONE_WEIGHT, NEW_WEIGHT, own.weight)
    for part, new in zip(whole, own.path, strict=True):
        part[young] = new
    return replace(reports, weight=weight, path=PathPoints(*whole))


def _judged(
    frame: Frame,
    tangent: Tangent,
    reports: OpenReports,
    delta: FloatArray,
    widened: float = 1.0,
) -> Judged:
    """Reports given each other and the biases; `widened` is a factor on the noise."""
    equations, noise = tangent.equations, frame.noise
    mean = tangent.start.start_mean - tangent.columns @ delta
    motion = tangent.start._replace(start_mean=mean)
    weights = reports.weight[tangent.at.rows]
    smoothed = smooth_tracks(equations, motion, weights, delta, spread=True)
    point = Point(tangent.at, weights, frame.density, noise.laws, noise.wrong, frame.constant_sd)
    judged = judge(tangent.model, point, smoothed, widened)
    steady = None
    if tangent.model.reports.varies:
        # see `steady_path` of the track posterior
        slow = motion._replace(q=STEADY * motion.q)
        steady = tangent.at.path(smooth_tracks(equations, slow, weights, delta).mean)
    weight = np.where(judged.placed, judged.weight, LONE_WEIGHT)
    at = tangent.at
    after = replace(reports, weight=weight[at.order], path=at.path(smoothed.mean))
    return Judged(after, judged, smoothed, weights, steady)


def follow_open(tangent: Tangent, reports: OpenReports) -> tuple[Sums, LiveTracks]:
    """What open reports say of the biases, and tracks after the closing slice."""
    p = tangent.model.reports.num_biases
    places = (tangent.knot + 1) * p, tangent.group
    weights = reports.weight[tangent.at.rows]
    sums, live = follow_tracks(tangent.equations, tangent.start, tangent.columns, places, weights)
    missing = NEWEST + 1 - len(sums.eta)
    sums = Sums(*(np.pad(s, [(0, missing)] + [(0, 0)] * (s.ndim - 1)) for s in sums))
    together = tangent.model.all_clocks
    if together is not None:
        # a common shift of all clocks is unobservable, whatever the tangent claims
        free = np.kron(np.eye(sums.eta.shape[1] // p), np.eye(p) - np.outer(together, together))
        sums = sums._replace(J=free @ sums.J @ free, eta=sums.eta @ free)
    return sums, live


def track_reports(frame: Frame, reports: OpenReports, target: IntArray) -> TrackReports:
    """As the track model has them."""
    scene = frame.scene
    return TrackReports(
        scene.seen.models,
        reports.kind,
        target,
        reports.time,
        reports.values,
        scene.num_biases,
        scene.dim,
        len(scene.seen.constants),
        scene.radius_m,
        reports.own,
        reports.turn,
    )


def tangent_of(frame: Frame, reports: OpenReports, steady: PathPoints | None = None) -> Tangent:
    """At the reports' paths."""
    scene, noise = frame.scene, frame.noise
    rows, target = np.unique(reports.track, return_inverse=True)
    model = TrackModel(
        track_reports(frame, reports, target),
        GaussianPrior.from_sd(scene.bias.prior_sd),
        noise.laws,
        acceleration=frame.density,
        acceleration_log_sd=0.0,
        wrong_share=tuple(noise.wrong),
        area_m2=frame.area_m2,
        start_sd=scene.start_sd,
        constant_sd=tuple(frame.constant_sd),
        guess=reports.path,
    )
    at = model.reports.linearise(frame.theta, reports.path, steady)
    start, columns = _starts(frame, model, at, rows)
    ahead = np.clip((frame.end - at.equations.time) / frame.slice_s, 0.0, frame.open_slices)
    back = np.minimum(ahead.astype(np.int64), frame.open_slices - 1)
    group = np.where(back == 0, NEWEST, OPEN)
    group[back == frame.open_slices - 1] = CLOSING
    knot = frame.window - 1 - back
    equations = _at_knots(at.equations, knot, ahead - back, model.reports.num_biases)
    return Tangent(model, at, equations, rows, start, columns, knot, group)


def _at_knots(
    equations: TrackEquations, knot: IntArray, share: FloatArray, p: int
) -> TrackEquations:
    """Biases between knots, linearly: a share (n,) of that before the knot of each report."""
    report = equations.report
    own = equations.column + (knot[report] * p)[:, None]
    before = share[report][:, None] * equations.response
    return equations._replace(
        column=np.hstack([own, own - p]),
        response=np.hstack([equations.response - before, before]),
    )


def _starts(
    frame: Frame, model: TrackModel, at: TrackLinearisation, rows: IntArray
) -> tuple[TrackMotion, FloatArray]:
    """States at each target's first open report: wide, or carried on from closed slices."""
    equations = at.equations
    wide = model.motion(equations, frame.density, frame.constant_sd)
    first = equations.target_start[:-1]
    d, K = model.reports.dim, len(rows)
    push = equations.push[first] if len(equations.push) else np.zeros((K, d))
    known = carried(frame.tracks.take(rows).live, equations.time[first], frame.density, push)
    begun = frame.tracks.begun[rows]
    size = wide.start_mean.shape[1]
    mean = np.where(begun[:, None], known.mean, wide.start_mean)
    broad = wide.start_variance[:, :, None] * np.eye(size)
    covariance = np.where(begun[:, None, None], known.covariance, broad)
    columns = np.where(begun[:, None, None], known.columns, 0.0)
    return TrackMotion(wide.q, mean, np.ascontiguousarray(covariance)), columns
