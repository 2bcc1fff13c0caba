"""Simulated traffic watched slice by slice, beside a batch fit of the same reports."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from probreg.noise import Contaminated, Gaussian
from probreg.posterior.tracks import TrackModel, fit_tracks
from probreg.prior import GaussianPrior
from probreg.problems.recording import recording_problem
from probreg.scenarios.traffic import TrafficScene, simulate
from probreg.watch import advance
from probreg.watch._begin import begin_with

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
    return recording.during(-np.inf, recording.time[0] + seconds)


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
    last = min(end, recording.time[-1])
    count = int((last - state.time) / state.settings.slice_s + 1e-9)
    # antennas turn in whole seconds: a report may stand on the edge of a slice
    edges = state.origin + (state.slices + np.arange(count + 1)) * state.settings.slice_s
    for start, until in pairwise(edges.tolist()):
        reports = recording.during(start, until)
        yield (reports if len(reports) else None), until


def watched(recording, state, end=np.inf):
    """The last state, and all results."""
    results = []
    for reports, until in in_slices(recording, state, end):
        state, result = advance(state, reports, until)
        results.append(result)
    return state, results
