"""Register a recording: the whole chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from probreg.errors import InvalidInputError
from probreg.recordings import Recording, Setup
from probreg.registration import _remarks
from probreg.registration._checks import Checks, check
from probreg.registration._choice import Chosen, choose
from probreg.registration._clock import Clock
from probreg.registration._held_out import HeldOut, score
from probreg.registration._identities import Identified, identify
from probreg.registration._laws import LAWS, LawChoice
from probreg.registration._missing import MissingTerm, missing_terms
from probreg.registration._posterior import Fitted, draw, fit
from probreg.registration._registration import Registration
from probreg.registration._verdicts import Judged, judge_reports

STEPS = (
    "associate",
    "laws",
    "mode",
    "draws",
    "held out",
    "observability",
    "missing terms",
    "verdicts",
)


def register(
    recording: Recording,
    setup: Setup,
    *,
    rng: np.random.Generator,
    laws: Sequence[LawChoice] = LAWS,
    num_draws: int = 2_000,
    holdout: float = 0.2,
    on_step: Callable[[str], object] = str,
) -> Registration:
    """Estimate the biases of a recording's sensors, with their uncertainty.

    Reports without identity are associated; laws are compared; biases, tracks, precisions and
    identities of all reports are fitted together; biases are drawn from their posterior.

    Parameters
    ----------
    recording : Recording
    setup : Setup
    rng : numpy.random.Generator
    laws : sequence of LawChoice
        Compared by leave-one-out on some targets; the best is used, or a simpler one
        that is as good within the standard error. See
        `known_laws` for others than the default ones.
    num_draws : int
        Posterior draws.
    holdout : float
        Share of the targets on which a fit to the others is scored; the posterior uses all.
    on_step : callable
        Called with the name of each step (one of `STEPS`) when it is over.

    Raises
    ------
    InvalidInputError
        One sensor only, no common target, no overlap in time, unknown terms, a law
        that tracks cannot take.
    """
    if not 0.0 < holdout < 1.0 or num_draws < 100:
        raise InvalidInputError(f"holdout {holdout} must be in (0, 1), num_draws 100 or more.")
    clock = Clock(on_step)
    known = clock.run("associate", identify, recording, setup)
    chosen = clock.run("laws", choose, known.model, laws)
    mode = clock.run("mode", fit, known, chosen)
    fitted = clock.run("draws", draw, known, mode, num_draws, rng)
    scored = clock.run("held out", score, fitted.fit, holdout, rng)
    checks = clock.run("observability", check, known, fitted.fit)
    missing = clock.run("missing terms", missing_terms, known.problem, chosen.choice, fitted.fit)
    judged = clock.run("verdicts", judge_reports, known, chosen, fitted)
    notes = _remarks.remarks(known, chosen, fitted, scored, checks, missing)
    return _result(known, chosen, fitted, scored, checks, judged, (missing, notes, clock.seconds))


_Last = tuple[tuple[MissingTerm, ...], tuple[str, ...], Mapping[str, float]]


def _result(
    known: Identified,
    chosen: Chosen,
    fitted: Fitted,
    scored: HeldOut | None,
    checks: Checks,
    judged: Judged,
    last: _Last,
) -> Registration:
    """What the steps found, in one; at last missing terms, remarks and times."""
    missing, notes, seconds = last
    return Registration(
        recording=known.problem.recording,
        setup=known.problem.setup,
        problem=known.problem,
        fit=fitted.fit,
        draws=fitted.draws,
        law=chosen.choice.name,
        laws=chosen.ranked,
        law_reports=chosen.reports,
        determined=checks.determined,
        outlier=judged.outlier_probability,
        held_out=scored,
        verdicts=judged.verdicts,
        cluster_ratio=checks.cluster_ratio,
        missing=missing,
        left_out=_remarks.refused(known.problem, fitted.fit),
        noise_scale=checks.noise_scale,
        accuracies=tuple(checks.accuracies),
        notes=notes,
        seconds=seconds,
    )
