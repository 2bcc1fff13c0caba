"""Register a recording: the whole chain."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence

import numpy as np

from probreg.association import associate, doubts
from probreg.errors import InvalidInputError
from probreg.noise import NoiseLaw, StudentT
from probreg.posterior import WeightedFit
from probreg.posterior.posterior import Posterior
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem
from probreg.problems.recording import RecordingProblem
from probreg.recordings import Recording, Setup
from probreg.registration import _remarks
from probreg.registration._accuracy import accuracies
from probreg.registration._choice import Chosen, choose_law, outlier_shares
from probreg.registration._clusters import cluster_ratio
from probreg.registration._fit import settle, some_rows, thinned
from probreg.registration._held_out import held_out
from probreg.registration._laws import LAWS, LawChoice
from probreg.registration._observed import determined
from probreg.registration._registration import Registration, Verdict
from probreg.samplers import PARETO_K, Draws, Gibbs, Importance, MetropolisHastings
from probreg.typing import FloatArray, IntArray

PROVISIONAL = StudentT(3.0)  # bears half of the rows being wrong
FEW_ROWS = 4_000  # for provisional fits
LAW_ROWS = 2_000  # for the comparison of laws
CHAIN_ROWS = 2_000  # up to which chains are cheap; beyond, importance sampling, if it can
MANY_ROWS = 20_000  # beyond which chains take too long
_ROUNDS = 2  # of association with the biases known better and better
_CHAINS = 4
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


class _Clock:
    """Seconds of each step; says which are over."""

    def __init__(self, on_step: Callable[[str], object]) -> None:
        self._on_step = on_step
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def stop(self, step: str) -> None:
        now = time.perf_counter()
        self.seconds[step] = self.seconds.get(step, 0.0) + now - self._last
        self._last = now
        self._on_step(step)


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
        Compared by leave-one-out on at most 2 000 rows evenly spread; the best is used.
    num_draws : int
        Posterior draws.
    holdout : float
        Share of the targets on which a fit to the others is scored; the posterior uses all.
    on_step : callable
        Called with the name of each step (one of `STEPS`) when it is over.

    Returns
    -------
    Registration

    Raises
    ------
    InvalidInputError
        One sensor only, no common target, no overlap in time, unknown terms, no fit.
    """
    if not 0.0 < holdout < 1.0 or num_draws < 100:
        raise InvalidInputError(f"holdout {holdout} must be in (0, 1), num_draws 100 or more.")
    clock, notes = _Clock(on_step), list[str]()
    given = recording
    notes += _remarks.at_once(given)
    if (recording.target < 0).any():
        recording = associate(given, setup)
        notes.append(_remarks.association(given, recording))
    clock.stop("associate")
    problem = RecordingProblem(recording, setup)
    prior = GaussianPrior.from_sd(problem.prior_sd)
    clock.stop("rows")
    recording, problem, theta, why = _identities(given, recording, setup, problem, prior)
    notes += _remarks.doubted(given, setup, why) + _remarks.stamps(given)
    clock.stop("provisional fit")
    linear = problem.linearise(theta)
    some = thinned(len(problem.plan), LAW_ROWS)
    chosen = choose_law(some_rows(linear, some), prior, laws, rng)
    notes += chosen.notes
    clock.stop("laws")
    law = chosen.fitted[chosen.choice.name]
    theta, linear = settle(problem, law, prior, theta, near=True)
    clock.stop("mode")
    posterior = Posterior(linear, chosen.choice.law, prior, chosen.choice.unknown)
    draws = _draw(posterior, num_draws, rng)
    clock.stop("draws")
    scored = held_out(problem, linear, law, prior, holdout, rng)
    clock.stop("held out")
    found = determined(linear, _information(linear, law, prior), prior)
    scale = _remarks.noise_scale(posterior, draws)
    notes += _remarks.undetermined(found) + _remarks.drawing(draws) + _remarks.scale(*scale)
    notes += _remarks.correction(scored) + _remarks.curvature(recording, chosen.choice.name)
    notes += _remarks.accuracy(accuracies(recording, setup, theta))
    notes += _remarks.far(problem.names, draws.mean[: len(theta)], problem.prior_sd)
    covariance = draws.covariance[: len(theta), : len(theta)]
    ratio = cluster_ratio(linear, law, problem.plan.target, theta, covariance)
    clock.stop("observability")
    outliers = outlier_shares(linear, theta, _contaminated(chosen, linear, prior, rng))
    verdicts = _verdicts(setup, problem, draws)
    clock.stop("verdicts")
    return Registration(
        recording,
        setup,
        problem,
        posterior,
        draws,
        chosen.ranked,
        len(some),
        found,
        outliers,
        scored,
        verdicts,
        ratio,
        _remarks.left_out(given, recording),
        scale,
        tuple(notes),
        clock.seconds,
    )


def _identities(
    given: Recording,
    recording: Recording,
    setup: Setup,
    problem: RecordingProblem,
    prior: GaussianPrior,
) -> tuple[Recording, RecordingProblem, FloatArray, IntArray]:
    """Associate with the biases known better and better; why each identity is doubted."""
    theta = _provisional(problem, prior, None)
    for _ in range(_ROUNDS):
        before = recording.target
        recording, why = _associate_again(given, setup, theta)
        problem = RecordingProblem(recording, setup)
        theta = _provisional(problem, prior, theta)
        if np.array_equal(before, recording.target):
            break
    return recording, problem, theta, why


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
    """Identities anew, the biases known: missing ones found, doubtful ones taken away, and why."""
    recording = given
    if (given.target < 0).any():
        recording = associate(given, setup, theta)
    why = doubts(recording, setup, theta)
    return dataclasses.replace(recording, target=np.where(why == 0, recording.target, -1)), why


def _draw(posterior: Posterior, num_draws: int, rng: np.random.Generator) -> Draws:
    """Importance sampling where rows are many and it can, chains otherwise."""
    rows = len(posterior.rows.size)
    a_chain = -(-num_draws // _CHAINS)
    if rows > CHAIN_ROWS:
        draws = Importance(oversample=1.0).sample(posterior, a_chain, _CHAINS, rng)
        if draws.facts["pareto_k"] <= PARETO_K or rows > MANY_ROWS:
            return draws
    sampler = Gibbs(walks=8) if posterior.noise.scale_mixture else MetropolisHastings()
    return sampler.sample(posterior, a_chain, _CHAINS, rng)


def _information(linear: LinearProblem, law: NoiseLaw, prior: GaussianPrior) -> FloatArray:
    fit = WeightedFit(linear, law, prior)
    return fit.normal_matrix(linear.whitened(), fit.mode().weights) - prior.precision


def _contaminated(
    chosen: Chosen,
    linear: LinearProblem,
    prior: GaussianPrior,
    rng: np.random.Generator,
) -> NoiseLaw | None:
    """The contaminated law, which marks outliers, whichever law won."""
    if "Contaminated" in chosen.fitted:
        return chosen.fitted["Contaminated"]
    contaminated = [choice for choice in LAWS if choice.name == "Contaminated"]
    some = some_rows(linear, thinned(len(linear.y), LAW_ROWS))
    try:
        return choose_law(some, prior, contaminated, rng).fitted["Contaminated"]
    except InvalidInputError:
        return None


def _verdicts(setup: Setup, problem: RecordingProblem, draws: Draws) -> tuple[Verdict, ...]:
    found = []
    for name, limit in setup.limits.items():
        size = np.abs(draws.flat[:, problem.model.numbers[name]])
        found.append(Verdict(name, float(limit), float((size > limit).mean())))
    return tuple(found)
