"""Which report is of which target, and the biases provisionally: one needs the other."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from probreg.association import associate, doubts
from probreg.noise import StudentT
from probreg.prior import GaussianPrior
from probreg.problems.recording import RecordingProblem
from probreg.recordings import Recording, Setup
from probreg.registration._fit import settle, thinned
from probreg.typing import FloatArray, IntArray

PROVISIONAL = StudentT(3.0)  # withstands half of the rows being wrong
FEW_ROWS = 4_000  # for provisional fits
_ROUNDS = 2  # of association with the biases known better and better


class Identified(NamedTuple):
    """A recording whose reports are known by their targets, and about where its biases lie.

    Attributes
    ----------
    given : Recording
    first : Recording
        As associated when nothing was known of the biases.
    problem : RecordingProblem
        Of the recording with the final identities.
    prior : GaussianPrior
    theta : ndarray, shape (p,)
        Provisional biases.
    why : ndarray of int, shape (reports,)
        Why identities are doubted, see `probreg.association.doubts`; 0 where they are not.
    """

    given: Recording
    first: Recording
    problem: RecordingProblem
    prior: GaussianPrior
    theta: FloatArray
    why: IntArray


def first_identities(recording: Recording, setup: Setup) -> Recording:
    """The recording with identities where there were none, no bias known."""
    return associate(recording, setup) if (recording.target < 0).any() else recording


def identify(given: Recording, problem: RecordingProblem) -> Identified:
    """Associate with the biases known better and better.

    Parameters
    ----------
    given : Recording
    problem : RecordingProblem
        Of the first identities.
    """
    first, setup = problem.recording, problem.setup
    prior = GaussianPrior.from_sd(problem.prior_sd)
    theta = _provisional(problem, prior, None)
    for _ in range(_ROUNDS):
        before = problem.recording.target
        recording, why = _associate_again(given, setup, theta)
        problem = RecordingProblem(recording, setup)
        theta = _provisional(problem, prior, theta)
        if np.array_equal(before, recording.target):
            break
    return Identified(given=given, first=first, problem=problem, prior=prior, theta=theta, why=why)


def _provisional(
    problem: RecordingProblem, prior: GaussianPrior, theta: FloatArray | None
) -> FloatArray:
    """The robust mode of some rows, from the last one where there is one."""
    rows = thinned(len(problem.plan), FEW_ROWS)
    few = problem if len(rows) == len(problem.plan) else problem.take(rows)
    start = problem.start if theta is None else theta
    return settle(few, PROVISIONAL, prior, start, near=theta is not None)[0]


def _associate_again(
    given: Recording, setup: Setup, theta: FloatArray
) -> tuple[Recording, IntArray]:
    """Identities afresh, the biases known: missing ones found, doubtful ones removed, and why."""
    recording = given
    if (given.target < 0).any():
        recording = associate(given, setup, theta)
    why = doubts(recording, setup, theta)
    return dataclasses.replace(recording, target=np.where(why == 0, recording.target, -1)), why
