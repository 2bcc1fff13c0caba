"""Which bias terms earn their place: targets held out in turn say."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import NoiseLaw, StudentT
from probreg.posterior import WeightedFit
from probreg.prior import GaussianPrior
from probreg.problems.recording import RecordingProblem, plan_rows
from probreg.recordings import Recording, Setup
from probreg.registration._fit import settle, some_rows
from probreg.registration._held_out import log_score
from probreg.typing import FloatArray, IntArray


class RankedTerms(NamedTuple):
    """A bias model's place among those compared.

    Attributes
    ----------
    name : str
    log_score : float
        Log predictive density of held-out targets, summed.
    behind : float
        How far below the best.
    standard_error : float
        Of `behind`, from the targets' differences; 0 for the best.
    unknowns : int
    """

    name: str
    log_score: float
    behind: float
    standard_error: float
    unknowns: int


def compare_terms(
    recording: Recording,
    setup: Setup,
    models: Mapping[str, Mapping[str, tuple[str, ...]]],
    *,
    rng: np.random.Generator,
    law: NoiseLaw | None = None,
    folds: int = 4,
) -> list[RankedTerms]:
    """Rank bias models by how well they predict targets they were not fitted to, best first.

    Parameters
    ----------
    recording : Recording
        With identities, as `Registration.recording`.
    setup : Setup
    models : mapping of str to mapping
        By name, what `Setup.biases` would be.
    rng : numpy.random.Generator
        Deals the targets to the folds.
    law : NoiseLaw, optional
        By default Student-t of 4 degrees of freedom.
    folds : int
        Parts of the targets, each predicted from the others.

    Raises
    ------
    InvalidInputError
        Fewer than two models, or fewer targets than folds.
    """
    if len(models) < 2:
        raise InvalidInputError("at least two bias models are needed for a comparison.")
    law = StudentT(4.0) if law is None else law
    clocks = any("time" in terms for model in models.values() for terms in model.values())
    plan = plan_rows(recording, setup, always_moving=clocks)  # the same rows for all
    targets = np.unique(plan.target)
    if len(targets) < folds:
        raise InvalidInputError(f"{len(targets)} targets cannot be dealt to {folds} folds.")
    fold = (rng.permutation(len(targets)) % folds)[np.searchsorted(targets, plan.target)]
    scores, unknowns = {}, {}
    for name, biases in models.items():
        problem = RecordingProblem(recording, _with(setup, biases), plan)
        scores[name] = _predicted(problem, fold, law)
        unknowns[name] = len(problem.names)
    return _ranked(scores, unknowns, plan.target)


def _ranked(
    scores: Mapping[str, FloatArray], unknowns: Mapping[str, int], target: IntArray
) -> list[RankedTerms]:
    """Models by the scores of their rows, best first; errors from differences of targets."""
    order = sorted(scores, key=lambda name: -float(scores[name].sum()))
    _, own = np.unique(target, return_inverse=True)
    best, ranked = scores[order[0]], []
    for name in order:
        gap = np.bincount(own, best - scores[name])
        error = float(np.sqrt(gap.size * np.var(gap))) if name != order[0] else 0.0
        ranked.append(
            RankedTerms(
                name=name,
                log_score=float(scores[name].sum()),
                behind=float(gap.sum()),
                standard_error=error,
                unknowns=unknowns[name],
            )
        )
    return ranked


def _predicted(problem: RecordingProblem, fold: IntArray, law: NoiseLaw) -> FloatArray:
    prior = GaussianPrior.from_sd(problem.prior_sd)
    _, linear = settle(problem, law, prior, problem.start)
    score = np.zeros(len(fold))
    for k in np.unique(fold):
        held = fold == k
        theta = WeightedFit(some_rows(linear, np.flatnonzero(~held)), law, prior).mode().theta
        score[held] = log_score(some_rows(linear, np.flatnonzero(held)), law, theta)
    return score


def _with(setup: Setup, biases: Mapping[str, tuple[str, ...]]) -> Setup:
    """The setup with other biases, priors and limits of those that are gone left out."""
    named = {f"{sensor}.{term}" for sensor, terms in biases.items() for term in terms}
    if any("heading" in terms for terms in biases.values()):
        named.add("platform.heading")
    kept = {name: sd for name, sd in setup.prior_sd.items() if name in named}
    return dataclasses.replace(setup, biases=biases, prior_sd=kept, limits={})
