"""A slice of time goes by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import ndtr

from probreg.errors import InvalidInputError
from probreg.recordings import Recording
from probreg.typing import FloatArray
from probreg.watch._close import close, counted
from probreg.watch._filters import (
    belief,
    levels,
    marginals,
    moved,
    next_knot,
    shares,
    step_variances,
    with_reports,
)
from probreg.watch._intake import Intake, take_in
from probreg.watch._refine import CLOSING, Frame, refine
from probreg.watch._scene import require_sensors
from probreg.watch.results import Counts, SliceResult
from probreg.watch.state import Filters, Tracks, WatchState

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
    refined = refine(frame, taken.reports, filters)
    found = belief(filters, *refined.information, state.theta.size)
    filters = replace(filters, evidence=found.log_evidence)
    variance = levels(settings, state.scene.bias.prior_sd)
    mean, sd = marginals(found, shares(filters, len(variance)))
    closed = close(frame, refined, settings.forget_s)
    fade = float(0.5 ** (settings.slice_s / settings.half_life_s))
    after = replace(
        state,
        slices=state.slices + 1,
        theta=frame.theta,
        mean=frame.theta + mean,
        sd=sd,
        noise=counted(frame, refined, fade),
        tracks=closed.tracks,
        reports=closed.reports,
        filters=with_reports(filters, refined.sums.J[CLOSING], refined.sums.eta[CLOSING]),
    )
    return after, _result(after, taken, closed.refused, variance)


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
    lost = live.columns.reshape(*live.mean.shape, -1, p).sum(axis=2) @ away
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


def _result(state: WatchState, taken: Intake, refused: int, variance: FloatArray) -> SliceResult:
    """What is said of a slice."""
    bias, share = state.scene.bias, shares(state.filters, len(variance))
    by_sensor = np.bincount(
        state.scene.sensor, taken.used, minlength=len(state.setup.sensors)
    ).astype(np.int64)
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
        by_sensor=by_sensor,
    )
