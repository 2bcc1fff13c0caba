"""Simulated traffic watched slice by slice, beside a batch fit of the same reports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from probreg.noise import Contaminated, Gaussian
from probreg.posterior.tracks import TrackModel, fit_tracks
from probreg.prior import GaussianPrior
from probreg.problems.recording import recording_problem
from probreg.scenarios.traffic import TrafficScene, simulate
from probreg.watch import advance
from probreg.watch._begin import begin_with

EDGE_S = 1e-7
DIRTY = {"wrong_share": 0.2, "outlier_share": 0.05}


def draw(seed, **scene):
    return simulate(TrafficScene(**scene), np.random.default_rng(seed))


def cut(recording, rows):
    """Some of the reports; `rows` may be a mask."""
    rows = np.flatnonzero(rows) if np.asarray(rows).dtype == bool else np.asarray(rows)
    return replace(
        recording,
        sensor=recording.sensor[rows],
        time=recording.time[rows],
        values=recording.values[rows],
        target=recording.target[rows],
    )


def up_to(recording, seconds):
    """Of the first so many seconds."""
    return cut(recording, recording.time <= recording.time[0] + seconds + EDGE_S)


def batch(recording, setup, dirty=False):
    """The problem, and its fit at known accelerations and laws; shares of wrong ones are found."""
    problem = recording_problem(recording, setup)
    law = Contaminated(0.05, 10.0) if dirty else Gaussian()
    model = TrackModel(
        problem.reports,
        GaussianPrior.from_sd(problem.prior_sd),
        (law,) * len(problem.reports.models),
        (frozenset({"nothing"}),) * len(problem.reports.models),
        acceleration=1.0,
        acceleration_log_sd=0.0,
        wrong_share=0.1 if dirty else 0.0,
        area_m2=problem.area_m2,
        guess=problem.guess,
    )
    return problem, fit_tracks(model, offers=0)


def begun(recording, setup, settings, seconds=120.0, dirty=False):
    """A watch without alarms, begun with the first seconds."""
    return begin_with(*batch(up_to(recording, seconds), setup, dirty), settings)


def in_slices(recording, state, end=np.inf):
    """What comes in each slice after a state, and when the slice ends."""
    until = state.time + state.settings.slice_s
    # antennas turn in whole seconds: a report may stand on the edge of a slice
    low = int(np.searchsorted(recording.time, state.time + EDGE_S))
    while until <= min(end, recording.time[-1]):
        high = int(np.searchsorted(recording.time, until + EDGE_S))
        yield (cut(recording, np.arange(low, high)) if high > low else None), until
        low, until = high, until + state.settings.slice_s


def watched(recording, state, end=np.inf):
    """The last state, and all results."""
    results = []
    for reports, until in in_slices(recording, state, end):
        state, result = advance(state, reports, until)
        results.append(result)
    return state, results
