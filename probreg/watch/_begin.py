"""The first minutes, in batch mode: a watch begins with what `register` finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks import LiveTracks
from probreg.noise import Contaminated, MixtureCounts
from probreg.posterior.tracks import TrackFit
from probreg.prior import GaussianPrior
from probreg.problems.recording import RecordingProblem
from probreg.problems.recording.track_reports import PathPoints
from probreg.recordings import Recording, Setup
from probreg.registration import LawChoice, register
from probreg.watch._advance import closed, frame_of
from probreg.watch._alarms import calibrated, first_alarms
from probreg.watch._filters import belief, first_filters, levels, weighed
from probreg.watch._refine import NEWEST, Refined, follow_open, tangent_of
from probreg.watch._scene import labels_of, scene_of
from probreg.watch.settings import WatchSettings
from probreg.watch.state import Noise, OpenReports, Tracks, WatchState

EDGE = 1e-9  # of a slice, by which rounding may put a stamp beyond its end


def begin(
    recording: Recording, setup: Setup, settings: WatchSettings, rng: np.random.Generator
) -> WatchState:
    """Begin a watch with a recording of the first minutes.

    Parameters
    ----------
    recording : Recording
        Five minutes are fine; slices count from its first report.
    setup : Setup
    settings : WatchSettings
    rng : numpy.random.Generator

    Raises
    ------
    InvalidInputError
        As `register` does: nothing that two sensors have in common.
    """
    laws = (LawChoice.usual(Contaminated()),)
    found = register(recording, setup, rng=rng, laws=laws)
    state = begin_with(found.problem, found.fit, settings)
    return with_thresholds(state, rng)


def begin_with(problem: RecordingProblem, fit: TrackFit, settings: WatchSettings) -> WatchState:
    """Begin a watch where a fit of the first minutes ends, without alarms."""
    model, scene = fit.model, scene_of(problem.setup, problem.kinds, fit.model.start_sd)
    time, p = problem.recording.time, fit.theta.size
    # a last stamp on the edge of a slice is of that slice
    slices = max(1, int(np.ceil((time[-1] - time[0]) / settings.slice_s - EDGE)))
    sensors, models = len(problem.setup.sensors), len(model.reports.models)
    state = WatchState(
        setup=problem.setup,
        settings=settings,
        scene=scene,
        origin=float(time[0]),
        slices=slices - 1,
        theta=fit.theta,
        density=fit.point.q * model.caution,
        area_m2=model.area_m2,
        constant_sd=fit.point.constant_sd,
        mean=fit.theta,
        sd=fit.sd,
        knots=np.tile(fit.theta, (settings.window, 1)),
        noise=_noise(fit),
        tracks=_tracks(problem, scene.size, settings.window * p),
        reports=_reports(fit),
        filters=first_filters(GaussianPrior.from_sd(problem.prior_sd), fit.theta, settings),
        alarms=first_alarms(models, sensors, p, settings.window * p),
    )
    frame = frame_of(state, state.theta, state.tracks)
    tangent = tangent_of(frame, state.reports)
    sums, live = follow_open(tangent, state.reports)
    refined = Refined(state.reports, tangent, None, sums, live)
    found = belief(state.filters, *refined.information, p)
    return closed(state, frame, weighed(state.filters, found.log_evidence), refined, found)


def with_thresholds(state: WatchState, rng: np.random.Generator) -> WatchState:
    """Alarms calibrated to what a slice says in this installation."""
    settings = state.settings
    frame = frame_of(state, state.theta, state.tracks)
    groups = len(state.noise.laws), len(state.setup.sensors)
    whole = state.reports.path.time <= state.time - settings.slice_s
    if not whole.any():
        raise InvalidInputError("too few reports to calibrate alarms: begin with some minutes.")
    # the last slice may be a part of one
    frame = frame._replace(end=state.time - settings.slice_s)
    reports = state.reports.take(whole)
    J = follow_open(tangent_of(frame, reports), reports)[0].J[NEWEST]
    prior_sd = state.scene.bias.prior_sd
    thresholds = calibrated(settings, (J, levels(settings, prior_sd)[0], prior_sd**2), groups, rng)
    return replace(state, alarms=replace(state.alarms, thresholds=thresholds))


def _noise(fit: TrackFit) -> Noise:
    laws, models = fit.point.laws, fit.model.reports.models
    sizes = [len(law.mixture(len(m.sigmas)).share) for law, m in zip(laws, models, strict=True)]
    counts = tuple(MixtureCounts(*(np.zeros(J) for _ in range(3))) for J in sizes)
    none = np.zeros(len(laws))
    assert fit.model.unknown is not None
    unknown = tuple(tuple(sorted(names)) for names in fit.model.unknown)
    return Noise(laws, laws, unknown, fit.point.wrong, fit.point.wrong, counts, none, none)


def _tracks(problem: RecordingProblem, size: int, columns: int) -> Tracks:
    """One a track of the problem, of which nothing is known yet."""
    target = problem.recording.target[problem.rows]
    names = labels_of(problem.recording)[problem.rows]
    by_target = dict(zip(target.tolist(), names.tolist(), strict=True))
    K = len(problem.owner)
    label = np.array([by_target.get(k, "") for k in problem.owner.tolist()], dtype=str)
    seen = np.full(K, -np.inf)
    np.maximum.at(seen, problem.reports.target, problem.reports.time)
    live = LiveTracks(
        np.zeros((K, size)), np.zeros((K, size, size)), np.zeros((K, size, columns)), np.zeros(K)
    )
    return Tracks(label, np.zeros(K, dtype=bool), seen, live)


def _reports(fit: TrackFit) -> OpenReports:
    """All reports under their last identities, with the weights and paths of the fit."""
    reports, d = fit.model.reports, fit.model.reports.dim
    n = len(reports)
    at = fit.point.tangent
    path = PathPoints(at.equations.time[at.order], fit.mean[:, :d], fit.mean[:, d : 2 * d])
    return OpenReports(
        reports.target,
        reports.sensor,
        reports.time,
        reports.values,
        np.zeros((n, d)) if reports.own is None else reports.own,
        np.zeros(n) if reports.turn is None else reports.turn,
        fit.weights,
        path,
    )
