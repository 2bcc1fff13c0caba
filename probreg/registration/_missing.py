"""Terms that the setup leaves out and the recording asks for, found by score tests."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.posterior.tracks import TrackFit, fit_tracks, score_missing, score_spread
from probreg.problems.recording import RecordingProblem, recording_problem
from probreg.problems.recording.models import target_term
from probreg.recordings import Setup
from probreg.registration._identities import of_some
from probreg.registration._laws import LawChoice
from probreg.registration._terms import with_biases
from probreg.registration._track_model import track_model
from probreg.sensors.terms import Term, known_terms

MOST_REPORTS = 20_000  # enough to see what matters
LEAST_CHI2 = 30.0  # sound recordings stay below 10 or so, wrong ones come in hundreds
LEAST_Z = 10.0  # of an error of targets; sound recordings stay below 4
LEAST_SDS = 4.0  # of a term that is fitted
MOST_TERMS = 4
OWN_TERMS = ("range", "time", "height")  # a transponder's delay, a late position, a height
TARGETS = "targets"


class MissingTerm(NamedTuple):
    """A term that is not in the setup.

    Attributes
    ----------
    name : str
        "sensor.term"; "targets.term" of an error that every target has one of its own of.
    unit : str
        SI.
    chi2 : float
        Of the score test; one degree of freedom. The square of z for errors of targets.
    value, sd : float
        What it would be, by the fit with it; the spread over targets for errors of their own,
        whose sd is not known (NaN).
    """

    name: str
    unit: str
    chi2: float
    value: float
    sd: float

    @property
    def of_targets(self) -> bool:
        """Whether every target has one of its own."""
        return self.name.startswith(f"{TARGETS}.")


class _Step(NamedTuple):
    """A term, and the problem and fit with it."""

    term: MissingTerm
    problem: RecordingProblem
    fit: TrackFit

    @property
    def score(self) -> float:
        """Log density of every report given all others, summed."""
        return float(self.fit.log_density.sum())


def missing_terms(
    problem: RecordingProblem, choice: LawChoice, fit: TrackFit
) -> tuple[MissingTerm, ...]:
    """Name the term that is missing most, fit again with it, and so on until none is left.

    Where both a bias and an error of targets seem to be missing, the one with which reports are
    predicted better is named.

    Parameters
    ----------
    problem : RecordingProblem
    choice : LawChoice
    fit : TrackFit
        Of all its tracks, or of some.
    """
    found: list[MissingTerm] = []
    at = fit
    if len(fit.model.reports) > MOST_REPORTS:
        at = fit_tracks(of_some(fit.model, MOST_REPORTS), near=fit)
    for _ in range(MOST_TERMS):
        best = _better(_with_bias(problem, choice, at), _with_own(problem, choice, at))
        if best is None:
            break
        found.append(best.term)
        problem, at = best.problem, best.fit
    return tuple(found)


def _better(bias: _Step | None, own: _Step | None) -> _Step | None:
    """An error of targets only if it stands out more than a bias and predicts better.

    It may absorb some of a bias that is missing.
    """
    if bias is None or own is None:
        return bias or own
    stands_out = own.term.chi2 > bias.term.chi2
    return own if stands_out and own.score >= bias.score else bias


def _with_bias(problem: RecordingProblem, choice: LawChoice, at: TrackFit) -> _Step | None:
    """The strongest missing bias, if it is clear in the fit that has it."""
    named = list(_candidates(problem))
    if not named:
        return None
    tests = score_missing(at, [models for _, _, models in named])
    k = int(np.argmax(tests.chi2))
    if tests.chi2[k] < LEAST_CHI2:
        return None
    name, term, _ = named[k]
    after = _fitted(problem, _with_term(problem.setup, name), choice)
    if after is None:
        return None
    number = after[0].model.numbers[name]
    value, sd = float(after[1].biases[number]), float(after[1].bias_sd[number])
    if abs(value) < LEAST_SDS * sd:
        return None  # what looked like it is something else
    return _Step(MissingTerm(name, term.unit, float(tests.chi2[k]), value, sd), *after)


def _with_own(problem: RecordingProblem, choice: LawChoice, at: TrackFit) -> _Step | None:
    """The strongest error that stays with targets, by score tests of variances."""
    named = []
    for name in OWN_TERMS:
        terms = {
            m: term
            for m, (own, _) in enumerate(problem.kinds)
            for term in [target_term(problem.setup.sensors[own], name)]
            if term is not None
        }
        if terms and name not in problem.constants:
            named.append((name, terms))
    if not named:
        return None
    tests = score_spread(at, [terms for _, terms in named])
    k = int(np.argmax(tests.z))
    if tests.z[k] < LEAST_Z or tests.sd[k] <= 0.0:
        return None
    name, unit = named[k][0], next(iter(named[k][1].values())).unit
    spreads = {**problem.setup.target_terms, name: float(tests.sd[k])}
    after = _fitted(problem, dataclasses.replace(problem.setup, target_terms=spreads), choice)
    if after is None:
        return None
    spread = float(after[1].point.constant_sd[list(after[0].constants).index(name)])
    chi2 = float(tests.z[k]) ** 2
    return _Step(MissingTerm(f"{TARGETS}.{name}", unit, chi2, spread, np.nan), *after)


def _fitted(
    problem: RecordingProblem, setup: Setup, choice: LawChoice
) -> tuple[RecordingProblem, TrackFit] | None:
    """The problem under another setup and the fit of some of its targets; None without one."""
    try:
        again = recording_problem(problem.recording, setup)
        return again, fit_tracks(of_some(track_model(again, choice), MOST_REPORTS))
    except InvalidInputError:
        return None


def _candidates(problem: RecordingProblem) -> Iterator[tuple[str, Term, dict[int, Term]]]:
    """Terms that sensors could have and do not, with the sensor models that they are of."""
    setup = problem.setup
    for s, sensor in enumerate(setup.sensors):
        given = setup.biases.get(sensor.name, ())
        for name, term in known_terms(sensor).items():
            if name in given or (name == "heading" and sensor.name not in setup.body_frame):
                continue
            if not given and not _of_references(term):
                continue
            models = {
                m: known_terms(setup.sensors[own])[name]
                for m, (own, along) in enumerate(problem.kinds)
                if (along if term.stamp else own) == s
            }
            if models:
                yield f"{term.owner}.{name}", term, models


def _of_references(term: Term) -> bool:
    """Whether a sensor declared free of biases may have it: a late stamp, a height."""
    return bool(term.stamp) or not term.sensor.gives_position


def _with_term(setup: Setup, full: str) -> Setup:
    """The setup with one more term."""
    owner, name = full.split(".", 1)
    biases = {s.name: tuple(setup.biases.get(s.name, ())) for s in setup.sensors}
    for sensor in setup.sensors:
        known = known_terms(sensor)
        if name not in known or known[name].owner != owner:
            continue
        if name != "heading" or sensor.name in setup.body_frame:
            biases[sensor.name] = (*biases[sensor.name], name)
    return with_biases(setup, biases)
