"""Terms that the setup leaves out and the recording asks for, found by score tests."""

from __future__ import annotations

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
LEAST_SDS = 4.0  # of a term that is fitted
MOST_TERMS = 4
OWN_TERMS = ("range", "time", "height")  # a transponder's delay, a late position, a height
LEAST_Z = 10.0  # of an error of targets; sound recordings stay below 4


class MissingTerm(NamedTuple):
    """A term that is not in the setup.

    Attributes
    ----------
    name : str
        "sensor.term".
    unit : str
        SI.
    chi2 : float
        Of the score test; one degree of freedom.
    value, sd : float
        What it would be, by the fit with it.
    """

    name: str
    unit: str
    chi2: float
    value: float
    sd: float


class OwnError(NamedTuple):
    """An error that targets have of their own and the setup does not allow for.

    Attributes
    ----------
    name : str
        Of the term: "range" as by the delay of a transponder, "time" as by a late position.
    unit : str
        SI.
    z : float
        Of the score test of its variance, one-sided.
    sd : float
        About how large it is from one target to another.
    """

    name: str
    unit: str
    z: float
    sd: float


class Missing(NamedTuple):
    """What the setup leaves out."""

    terms: tuple[MissingTerm, ...]
    own: tuple[OwnError, ...]


def find_missing(problem: RecordingProblem, choice: LawChoice, fit: TrackFit) -> Missing:
    """Name the strongest missing term, fit again with it, and so on; then errors of targets.

    Parameters
    ----------
    problem : RecordingProblem
    choice : LawChoice
    fit : TrackFit
        Of all its tracks, or of some.
    """
    found: list[MissingTerm] = []
    current, at = problem, fit
    if len(fit.model.reports) > MOST_REPORTS:
        at = fit_tracks(of_some(fit.model, MOST_REPORTS))
    for _ in range(MOST_TERMS):
        best = _strongest(current, at)
        if best is None or best[1] < LEAST_CHI2:
            break
        (name, term), chi2 = best
        setup = _with_term(current.setup, name)
        try:
            current = recording_problem(problem.recording, setup)
            at = fit_tracks(of_some(track_model(current, choice), MOST_REPORTS))
        except InvalidInputError:
            break
        k = current.model.numbers[name]
        value, sd = float(at.theta[k]), float(at.sd[k])
        if abs(value) < LEAST_SDS * sd:
            break  # what looked like it is something else
        found.append(MissingTerm(name, term.unit, chi2, value, sd))
    return Missing(tuple(found), own_errors(current, at))


def own_errors(problem: RecordingProblem, fit: TrackFit) -> tuple[OwnError, ...]:
    """Errors that stay with targets, by score tests of their variances."""
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
        return ()
    found = score_spread(fit, [terms for _, terms in named])
    return tuple(
        OwnError(name, next(iter(terms.values())).unit, float(z), float(sd))
        for (name, terms), z, sd in zip(named, found.z, found.sd, strict=True)
        if z > LEAST_Z
    )


def _strongest(problem: RecordingProblem, fit: TrackFit) -> tuple[tuple[str, Term], float] | None:
    """The missing term of the largest chi-square."""
    named = list(_candidates(problem))
    if not named:
        return None
    tests = score_missing(fit, [models for _, _, models in named])
    k = int(np.argmax(tests.chi2))
    return (named[k][0], named[k][1]), float(tests.chi2[k])


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
        if owner in (sensor.name, "platform"):
            known = known_terms(sensor)
            if name in known and known[name].owner == owner:
                biases[sensor.name] = (*biases[sensor.name], name)
    return with_biases(setup, biases)
