"""Register a recording: the whole chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from probreg.errors import InvalidInputError
from probreg.problems.recording import RecordingProblem
from probreg.recordings import Recording, Setup
from probreg.registration import _remarks
from probreg.registration._checks import Checks, check
from probreg.registration._choice import Chosen, choose
from probreg.registration._clock import Clock
from probreg.registration._held_out import HeldOut, score
from probreg.registration._identities import Identified, first_identities, identify
from probreg.registration._laws import LAWS, LawChoice
from probreg.registration._posterior import Fitted, draw, fit
from probreg.registration._registration import Registration
from probreg.registration._verdicts import Judged, judge
from probreg.samplers import Draws

STEPS = (
    "associate",
    "rows",
    "provisional fit",
    "laws",
    "mode",
    "draws",
    "held out",
    "observability",
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

    Reports without identity are associated; identities that neighbouring reports contradict are
    taken away; rows are formed, laws compared, biases drawn from their posterior.

    Parameters
    ----------
    recording : Recording
    setup : Setup
    rng : numpy.random.Generator
    laws : sequence of LawChoice
        Compared by leave-one-out on at most 2 000 rows evenly spread; the best is used. See
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
        One sensor only, no common target, no overlap in time, unknown terms, no fit.
    """
    if not 0.0 < holdout < 1.0 or num_draws < 100:
        raise InvalidInputError(f"holdout {holdout} must be in (0, 1), num_draws 100 or more.")
    clock = Clock(on_step)
    named = clock.run("associate", first_identities, recording, setup)
    problem = clock.run("rows", RecordingProblem, named, setup)
    known = clock.run("provisional fit", identify, recording, problem)
    chosen = clock.run("laws", choose, known, laws, rng)
    fitted = clock.run("mode", fit, known, chosen)
    draws = clock.run("draws", draw, fitted.posterior, num_draws, rng)
    scored = clock.run("held out", score, known, fitted, holdout, rng)
    checks = clock.run("observability", check, known, fitted, draws)
    judged = clock.run("verdicts", judge, known, chosen, fitted, draws, rng)
    return _result(known, chosen, fitted, draws, scored, checks, judged, clock.seconds)


def _result(
    known: Identified,
    chosen: Chosen,
    fitted: Fitted,
    draws: Draws,
    scored: HeldOut | None,
    checks: Checks,
    judged: Judged,
    seconds: Mapping[str, float],
) -> Registration:
    """What the steps found, in one."""
    recording = known.problem.recording
    return Registration(
        recording=recording,
        setup=known.problem.setup,
        problem=known.problem,
        posterior=fitted.posterior,
        draws=draws,
        laws=chosen.ranked,
        law_rows=chosen.rows,
        determined=checks.determined,
        outlier_probability=judged.outlier_probability,
        held_out=scored,
        verdicts=judged.verdicts,
        cluster_ratio=checks.cluster_ratio,
        left_out=_remarks.left_out(known.given, recording),
        noise_scale=checks.noise_scale,
        residuals=checks.residuals,
        notes=_remarks.remarks(known, chosen, draws, scored, checks),
        seconds=seconds,
    )
