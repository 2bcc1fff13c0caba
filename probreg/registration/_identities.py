"""Which report is of which target, and the biases provisionally: one needs the other."""

from __future__ import annotations

from typing import NamedTuple

from probreg.association import associate
from probreg.noise import Contaminated
from probreg.posterior.tracks import TrackModel, fit_tracks
from probreg.posterior.tracks.steps import MANY_REPORTS, some_targets
from probreg.problems.recording import RecordingProblem, recording_problem
from probreg.recordings import Recording, Setup
from probreg.registration._laws import LawChoice
from probreg.registration._track_model import track_model

PROVISIONAL = LawChoice.usual(Contaminated())
_ROUNDS = 2  # of association with the biases known better and better


class Identified(NamedTuple):
    """A recording whose reports are known by their targets.

    Attributes
    ----------
    given : Recording
    first : Recording
        As associated when nothing was known of the biases.
    problem : RecordingProblem
        Of the recording with its identities.
    model : TrackModel
        Of its tracks, under a provisional law.
    """

    given: Recording
    first: Recording
    problem: RecordingProblem
    model: TrackModel


def identify(recording: Recording, setup: Setup) -> Identified:
    """Fill in identities that are missing, with the biases known better and better.

    Identities that are there stay: the fit of the tracks judges each of them.
    """
    missing = (recording.target < 0).any()
    first = associate(recording, setup) if missing else recording
    problem = recording_problem(first, setup)
    model = track_model(problem, PROVISIONAL)
    for _ in range(_ROUNDS if missing else 0):
        theta = fit_tracks(of_some(model, MANY_REPORTS)).over_time
        again = associate(recording, setup, theta)
        if (again.target == problem.recording.target).all():
            break
        problem = recording_problem(again, setup)
        model = track_model(problem, PROVISIONAL)
    return Identified(recording, first, problem, model)


def of_some(model: TrackModel, most: int) -> TrackModel:
    """The model of some targets, evenly chosen, with about so many reports."""
    among = some_targets(model.reports.counts, most)
    return model if among is None else model.of_targets(among)
