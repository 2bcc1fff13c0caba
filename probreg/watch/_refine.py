"""Weights and paths of the open reports, and what they say of the biases."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.motion.tracks import (
    LiveTracks,
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
from probreg.problems.recording.track_reports import PathPoints, TrackLinearisation, TrackReports
from probreg.typing import FloatArray, IntArray
from probreg.watch._filters import whole_belief
from probreg.watch._scene import Scene
from probreg.watch.state import Filters, Noise, OpenReports, Tracks

NEW_WEIGHT = 0.01  # of reports that no one has judged, and of those that no other places
ROUNDS = 3
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
    rows : ndarray of int
        Of the tracks that have open reports.
    start : TrackMotion
    columns : ndarray
    knot, group : ndarray of int, shape (n,)
        In the order of the tangent.
    """

    model: TrackModel
    at: TrackLinearisation
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
    """

    reports: OpenReports
    tangent: Tangent | None
    judged: Judgement | None
    sums: Sums
    live: LiveTracks | None

    @property
    def information(self) -> tuple[FloatArray, FloatArray]:
        """J and eta of all open reports."""
        return self.sums.J.sum(axis=0), self.sums.eta.sum(axis=0)


def refine(frame: Frame, reports: OpenReports, filters: Filters) -> Refined:
    """Judge the open reports given each other, at the biases that follow from them."""
    C = frame.window * frame.scene.num_biases
    if not len(reports):
        empty = Sums(np.zeros((3, C, C)), np.zeros((3, C)), np.zeros(3))
        return Refined(reports, None, None, empty, None)
    delta, _ = whole_belief(filters, np.zeros((C, C)), np.zeros(C))
    tangent, steady = tangent_of(frame, reports), None
    for k in range(ROUNDS):
        equations = _at_knots(tangent)
        motion = tangent.start._replace(
            start_mean=tangent.start.start_mean - tangent.columns @ delta
        )
        weights = reports.weight[tangent.at.rows]
        smoothed = smooth_tracks(equations, motion, weights, delta, spread=True)
        point = Point(
            tangent.at, weights, frame.density, frame.noise.laws, frame.noise.wrong,
            frame.constant_sd,
        )  # fmt: skip
        judged = judge(tangent.model, point, smoothed)
        weight = np.where(judged.placed, judged.weight, NEW_WEIGHT)
        reports = _written(reports, tangent.at, weight, smoothed.mean)
        if k + 1 < ROUNDS:
            if tangent.model.reports.varies:
                steady = _steady(tangent, equations, motion, weights, delta)
            tangent = tangent_of(frame, reports, steady)
            J, eta = (part.sum(axis=0) for part in follow_open(tangent, reports)[0][:2])
            delta, _ = whole_belief(filters, J, eta)
    sums, live = follow_open(tangent, reports)
    return Refined(reports, tangent, judged, sums, live)


def follow_open(tangent: Tangent, reports: OpenReports) -> tuple[Sums, LiveTracks]:
    """What open reports say of the biases, and tracks after the closing slice."""
    at, p = tangent.at, tangent.model.reports.num_biases
    places = tangent.knot, tangent.group
    weights = reports.weight[at.rows]
    sums, live = follow_tracks(at.equations, tangent.start, tangent.columns, p, places, weights)
    missing = NEWEST + 1 - len(sums.eta)
    sums = Sums(*(np.pad(s, [(0, missing)] + [(0, 0)] * (s.ndim - 1)) for s in sums))
    together = tangent.model.all_clocks
    if together is not None:
        # a common shift of all clocks is unobservable, whatever the tangent claims
        free = np.kron(np.eye(sums.eta.shape[1] // p), np.eye(p) - np.outer(together, together))
        sums = sums._replace(J=free @ sums.J @ free, eta=sums.eta @ free)
    return sums, live


def _at_knots(tangent: Tangent) -> TrackEquations:
    """Equations whose columns are those of the window."""
    equations = tangent.at.equations
    first = tangent.knot[equations.report] * tangent.model.reports.num_biases
    return equations._replace(column=equations.column + first[:, None])


def _steady(
    tangent: Tangent,
    equations: TrackEquations,
    motion: TrackMotion,
    weights: FloatArray,
    delta: FloatArray,
) -> PathPoints:
    """Paths for the columns of terms; see `steady_path` of the track posterior."""
    slow = motion._replace(q=STEADY * motion.q)
    return tangent.at.path(smooth_tracks(equations, slow, weights, delta).mean)


def _written(
    reports: OpenReports, at: TrackLinearisation, weight: FloatArray, states: FloatArray
) -> OpenReports:
    """With weights and paths that are in the order of a tangent."""
    arrays = [reports.track, reports.kind, reports.time, reports.values, reports.own, reports.turn]
    return OpenReports(*arrays, weight[at.order], at.path(states))


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
    back = np.floor((frame.end - at.equations.time) / frame.slice_s).astype(np.int64)
    back = np.clip(back, 0, frame.open_slices - 1)
    group = np.where(back == 0, NEWEST, OPEN)
    group[back == frame.open_slices - 1] = CLOSING
    return Tangent(model, at, rows, start, columns, frame.window - 1 - back, group)


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
