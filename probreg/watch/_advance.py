"""A slice of time goes by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import ndtr

from probreg.errors import InvalidInputError
from probreg.noise import MixtureCounts
from probreg.recordings import Recording
from probreg.typing import FloatArray, IntArray
from probreg.watch._alarms import (
    Clock,
    Heard,
    listen_changes,
    listen_noise,
    listen_silence,
)
from probreg.watch._changes import Found, Slice
from probreg.watch._close import REFUSED, close, counted
from probreg.watch._filters import (
    Belief,
    as_before,
    belief,
    levels,
    marginals,
    moved,
    next_knot,
    shares,
    step_variances,
    weighed,
    whole_belief,
    widened,
    with_reports,
)
from probreg.watch._intake import Intake, take_in
from probreg.watch._refine import CLOSING, NEW_WEIGHT, NEWEST, Frame, Refined, refine
from probreg.watch._scene import require_sensors
from probreg.watch._usual import unsuspected
from probreg.watch._watchdogs import louder, scaled
from probreg.watch.results import Alarm, Counts, SliceResult
from probreg.watch.state import Alarms, Filters, Noise, Tracks, WatchState

BEYOND = 1.5  # prior standard deviations of a bias after a step, about what it was
_SOON_S = 1e-6


def advance(
    state: WatchState, reports: Recording | None, until: float
) -> tuple[WatchState, SliceResult]:
    """Take in the reports of one slice.

    Parameters
    ----------
    state : WatchState
    reports : Recording or None
        That have come since, late ones too, of the same sensors; None if there are none.
        Identities are matched by their labels.
    until : float
        End of the slice, seconds: `state.time` and a slice.

    Returns
    -------
    state : WatchState
    result : SliceResult

    Raises
    ------
    InvalidInputError
        Another end of the slice, other sensors, reports from beyond the slice.
    """
    settings = state.settings
    _require_slice(state, reports, until)
    frame, filters = next_slice(state)
    opened = frame.end - settings.slice_s - max(settings.delay_s, _SOON_S)
    taken = take_in(frame, state.reports, state.setup, reports, opened)
    frame = frame._replace(tracks=taken.tracks)
    knots = (np.vstack([state.knots[1:], state.knots[-1]]) - frame.theta).reshape(-1)
    refined = refine(frame, taken.reports, filters, knots)
    clock = Clock(state.origin, settings.slice_s, state.slices)
    names = tuple(sensor.name for sensor in state.setup.sensors)
    kinds = tuple(names[s] for s in state.scene.sensor.tolist())
    counts = sensor_counts(state, taken)
    heard = _listened(state.alarms, frame, filters, refined, clock, (names, kinds, counts))
    raised = heard.raised
    if heard.step is None:
        found = belief(filters, *refined.information, state.theta.size)
        filters = weighed(filters, found.log_evidence)
    else:
        filters, refined, found = _after_step(frame, filters, refined, knots, (heard.step, clock))
        size, sd = step_size(filters, refined, heard.step, clock.number - heard.step.begun)
        raised = (replace(raised[0], size=size, sd=sd), *raised[1:])
    after = closed(state, frame, filters, refined, found)
    after = replace(after, alarms=heard.alarms, noise=_noisier(after.noise, heard))
    return after, _result(after, taken, _refused(refined), raised)


def _listened(
    alarms: Alarms,
    frame: Frame,
    filters: Filters,
    refined: Refined,
    clock: Clock,
    sensors: tuple[tuple[str, ...], tuple[str, ...], IntArray],
) -> Heard:
    """Alarms of all kinds; where biases have changed noise is no question.

    `sensors` are their names, those of the models' sensors, and counts of reports.
    """
    names, kinds, counts = sensors
    mean, covariance = whole_belief(filters, *refined.information, which=-1)
    J, eta = refined.sums.J[NEWEST], refined.sums.eta[NEWEST]
    now = Slice(J, eta - J @ mean, covariance)
    changes = listen_changes(alarms, now, clock, frame.scene.bias)
    silence = listen_silence(changes.alarms, counts, names, clock)
    raised = changes.raised + silence.raised
    if changes.raised:
        noise = unsuspected(alarms.noise)
        return Heard(replace(silence.alarms, noise=noise), raised, changes.step)
    heard = listen_noise(silence.alarms, louder(frame, refined), kinds, clock)
    return Heard(heard.alarms, raised + heard.raised, None, heard.louder)


def _after_step(
    frame: Frame,
    filters: Filters,
    refined: Refined,
    knots: FloatArray,
    step: tuple[Found, Clock],
) -> tuple[Filters, Refined, Belief]:
    """Biases of the sensor may be anything from the step on, and its reports are judged afresh."""
    (found, clock), bias = step, frame.scene.bias
    ago = clock.number - found.begun
    sensor = bias.names[found.term].rsplit(".", 1)[0]
    own = np.array([name.rsplit(".", 1)[0] == sensor for name in bias.names])
    more = np.where(own, (BEYOND * bias.prior_sd) ** 2, 0.0)
    filters = widened(filters, max(1, frame.window - 1 - ago), more)
    models = frame.scene.seen.models
    doubted = np.array([any(own[c] for c, _ in model.terms) for model in models])
    again = doubted[refined.reports.kind] & (refined.reports.time >= clock.start(found.begun))
    weight = np.where(again, NEW_WEIGHT, refined.reports.weight)
    refined = refine(frame, replace(refined.reports, weight=weight), filters, knots)
    knots, _ = whole_belief(filters, *refined.information)
    refined = refine(frame, refined.reports, filters, knots)
    believed = belief(filters, *refined.information, len(own))
    return as_before(filters, believed.log_evidence, ago + 1), refined, believed


def closed(
    state: WatchState, frame: Frame, filters: Filters, refined: Refined, found: Belief
) -> WatchState:
    """The state with a slice more, the oldest open one closed."""
    settings = state.settings
    variance = levels(settings, state.scene.bias.prior_sd)
    mean, sd = marginals(found, shares(filters, len(variance)))
    knots, _ = whole_belief(filters, *refined.information)
    tracks, reports = close(frame, refined, settings.forget_s)
    fade = float(0.5 ** (settings.slice_s / settings.half_life_s))
    return replace(
        state,
        slices=state.slices + 1,
        theta=frame.theta,
        mean=frame.theta + mean,
        sd=sd,
        knots=frame.theta + knots.reshape(settings.window, -1),
        noise=counted(frame, refined, fade),
        tracks=tracks,
        reports=reports,
        filters=with_reports(filters, refined.sums.J[CLOSING], refined.sums.eta[CLOSING]),
    )


def step_size(filters: Filters, refined: Refined, step: Found, ago: int) -> tuple[float, float]:
    """Size of a step and its standard deviation, once beliefs are free to follow it.

    Beliefs grow linearly through the slice of the step, and their end is fitted to its reports and
    those of the `ago` slices since: to a step at a share u of the slice they give
    ((1 - u^2) / 2 + ago) / (1 / 3 + ago) times its size. Over a uniform u that has mean one and
    variance (1 / 45) / (1 / 3 + ago)^2.
    """
    mean, covariance = whole_belief(filters, *refined.information)
    p = filters.step.shape[2]
    newest = len(mean) - p + step.term
    before = newest - (ago + 1) * p
    if before < 0:
        return step.size, step.sd
    size = float(mean[newest] - mean[before])
    both = covariance[np.ix_([newest, before], [newest, before])]
    moment = size**2 / 45.0 / (1.0 / 3.0 + ago) ** 2
    return size, float(np.sqrt(both[0, 0] + both[1, 1] - 2.0 * both[0, 1] + moment))


def _noisier(noise: Noise, heard: Heard) -> Noise:
    """Laws follow an alarm at once, and what was counted before is forgotten."""
    laws, counts = list(noise.laws), list(noise.counts)
    for s, factor in heard.louder:
        laws[s] = scaled(laws[s], factor)
        counts[s] = MixtureCounts(*(np.zeros_like(part) for part in counts[s]))
    return replace(noise, laws=tuple(laws), counts=tuple(counts))


def _refused(refined: Refined) -> int:
    """Reports of the closing slice that are not believed."""
    if refined.tangent is None:
        return 0
    weight = refined.reports.weight[refined.tangent.at.rows]
    return int((weight[refined.tangent.group == CLOSING] < REFUSED).sum())


def frame_of(state: WatchState, theta: FloatArray, tracks: Tracks) -> Frame:
    """Of the slice that comes next."""
    settings = state.settings
    return Frame(
        state.scene,
        theta,
        state.density,
        state.area_m2,
        state.constant_sd,
        state.noise,
        tracks,
        settings.window,
        settings.open_slices,
        settings.slice_s,
        state.time + settings.slice_s,
    )


def next_slice(state: WatchState) -> tuple[Frame, Filters]:
    """A knot more, and everything about the biases as they are believed to be now."""
    p = state.theta.size
    variance = levels(state.settings, state.scene.bias.prior_sd)
    filters = next_knot(state.filters, variance)
    away = state.mean - state.theta
    live = state.tracks.live
    knots = live.columns.reshape(*live.mean.shape, state.settings.window, p)
    lost = knots.sum(axis=2) @ away
    tracks = replace(state.tracks, live=live._replace(mean=live.mean - lost))
    return frame_of(state, state.theta + away, tracks), moved(filters, away)


def _require_slice(state: WatchState, reports: Recording | None, until: float) -> None:
    end = state.time + state.settings.slice_s
    if not abs(until - end) < _SOON_S:
        raise InvalidInputError(f"until is {until}; the next slice ends at {end}.")
    if reports is None:
        return
    require_sensors(state.setup, reports)
    beyond = int((reports.time > end + _SOON_S).sum())
    if beyond:
        raise InvalidInputError(
            f"{beyond} reports are later than the end {end} of the slice; hand them over with "
            "their own."
        )


def sensor_counts(state: WatchState, taken: Intake) -> IntArray:
    """Reports of a slice by sensor, those that came beside others not counted."""
    kinds = state.scene.seen.kinds
    alone = np.array([s == along for s, along in kinds])
    sensors = len(state.setup.sensors)
    counts = np.bincount(state.scene.sensor, taken.used * alone, minlength=sensors)
    return counts.astype(np.int64)


def _result(
    state: WatchState, taken: Intake, refused: int, raised: tuple[Alarm, ...]
) -> SliceResult:
    """What is said of a slice."""
    bias = state.scene.bias
    variance = levels(state.settings, bias.prior_sd)
    share = shares(state.filters, len(variance))
    per_minute = 60.0 / state.settings.slice_s
    spread = np.sqrt(step_variances(state.filters, variance)[0] * per_minute)
    exceeded = {}
    for name, limit in state.setup.limits.items():
        c = bias.numbers[name]
        outside = ndtr((-limit - state.mean[c]) / state.sd[c])
        outside += ndtr((state.mean[c] - limit) / state.sd[c])
        exceeded[name] = float(outside)
    return SliceResult(
        time=state.time,
        names=bias.names,
        units=bias.units,
        mean=state.mean,
        sd=state.sd,
        constant=share[:, 0],
        exceeded=exceeded,
        spread=spread,
        counts=Counts(int(taken.used.sum()), refused, taken.late, taken.unplaced),
        sensors=tuple(sensor.name for sensor in state.setup.sensors),
        by_sensor=sensor_counts(state, taken),
        alarms=raised,
    )
