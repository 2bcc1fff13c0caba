"""Which bias terms earn their place: targets held out in turn say."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.posterior.tracks import (
    TrackFit,
    fit_tracks,
    predict,
    some_targets_say,
    telling_targets,
)
from probreg.problems.recording import recording_problem
from probreg.recordings import Recording, Setup
from probreg.registration._identities import PROVISIONAL, of_some
from probreg.registration._laws import LawChoice
from probreg.registration._track_model import track_model
from probreg.typing import FloatArray, IntArray

TERM_REPORTS = 10_000  # for the comparison of terms


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
    law: LawChoice = PROVISIONAL,
    folds: int = 4,
) -> list[RankedTerms]:
    """Rank bias models by how well they predict targets they were not fitted to, best first.

    Laws, acceleration and precisions are those of each model's fit to all targets; the biases of
    each part of the targets are those of the others.

    Parameters
    ----------
    recording : Recording
        With identities, as `Registration.recording`.
    setup : Setup
    models : mapping of str to mapping
        By name, what `Setup.biases` would be.
    rng : numpy.random.Generator
        Deals the targets to the folds.
    law : LawChoice
    folds : int
        Parts of the targets, each predicted from the others.

    Raises
    ------
    InvalidInputError
        Fewer than two models, or fewer targets than folds.
    """
    if len(models) < 2:
        raise InvalidInputError("at least two bias models are needed for a comparison.")
    scores, unknowns = {}, {}
    fold: IntArray | None = None
    for name, biases in models.items():
        problem = recording_problem(recording, with_biases(setup, biases))
        fit = fit_tracks(of_some(track_model(problem, law), TERM_REPORTS), offers=0)
        if fold is None:
            K = fit.model.reports.num_targets
            if len(telling_targets(fit)) < folds:
                raise InvalidInputError(
                    f"{len(telling_targets(fit))} targets cannot be dealt to {folds} folds."
                )
            fold = rng.permutation(K) % folds
        scores[name] = _predicted(fit, fold)
        unknowns[name] = len(problem.names)
    return _ranked(scores, unknowns)


def _ranked(scores: Mapping[str, FloatArray], unknowns: Mapping[str, int]) -> list[RankedTerms]:
    """Models by the scores of targets, best first; errors from differences of targets."""
    order = sorted(scores, key=lambda name: -float(scores[name].sum()))
    best, ranked = scores[order[0]], []
    for name in order:
        gap = best - scores[name]
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


def _predicted(fit: TrackFit, fold: IntArray) -> FloatArray:
    """Score (targets,) of each target by the biases of the other folds."""
    score = np.zeros(len(fold))
    for k in np.unique(fold):
        held, rest = np.flatnonzero(fold == k), np.flatnonzero(fold != k)
        found = predict(fit, some_targets_say(fit, rest), held)
        own = fit.model.reports.target[found.rows][found.tangent.rows]
        np.add.at(score, own, found.judged.log_density)
    return score


def with_biases(setup: Setup, biases: Mapping[str, tuple[str, ...]]) -> Setup:
    """The setup with other biases, priors and limits of those that are gone left out."""
    named = {f"{sensor}.{term}" for sensor, terms in biases.items() for term in terms}
    if any("heading" in terms for terms in biases.values()):
        named.add("platform.heading")
    kept = {name: sd for name, sd in setup.prior_sd.items() if name in named}
    drift = {name: kind for name, kind in setup.drift.items() if name in named}
    drift_sd = {name: sd for name, sd in setup.drift_sd.items() if name in drift}
    return dataclasses.replace(
        setup, biases=biases, prior_sd=kept, limits={}, drift=drift, drift_sd=drift_sd
    )
