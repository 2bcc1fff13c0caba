"""Which rows hold an outlier, and which biases exceed their limits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import Contaminated
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem
from probreg.problems.recording import RecordingProblem
from probreg.registration._choice import LAW_ROWS, Chosen, choose_law
from probreg.registration._fit import some_rows, thinned
from probreg.registration._identities import Identified
from probreg.registration._laws import LawChoice
from probreg.registration._posterior import Fitted
from probreg.registration._registration import Verdict
from probreg.samplers import Draws
from probreg.typing import FloatArray


class Judged(NamedTuple):
    """Rows and biases, each with the probability that speaks against it.

    Attributes
    ----------
    outlier_probability : ndarray, shape (rows,)
        That a row is an outlier; NaN if the contaminated law cannot be fitted.
    verdicts : tuple of Verdict
    """

    outlier_probability: FloatArray
    verdicts: tuple[Verdict, ...]


def judge(
    known: Identified, chosen: Chosen, fitted: Fitted, draws: Draws, rng: np.random.Generator
) -> Judged:
    """Judge rows under the contaminated law, which marks outliers, whichever law was chosen."""
    rows = fitted.linear.whitened()
    share = np.full(len(rows.size), np.nan)
    law = _contaminated(fitted.linear, chosen, known.prior, rng)
    if law is not None:
        share = np.asarray(law.outlier_probability(rows.residual(fitted.theta), rows.size))
    return Judged(outlier_probability=share, verdicts=_verdicts(known.problem, draws))


def _contaminated(
    linear: LinearProblem, chosen: Chosen, prior: GaussianPrior, rng: np.random.Generator
) -> Contaminated | None:
    """The contaminated law at its mode, fitted to some rows unless the comparison has it."""
    for law in chosen.fitted.values():
        if isinstance(law, Contaminated):
            return law
    some = some_rows(linear, thinned(len(linear.y), LAW_ROWS))
    try:
        law = choose_law(some, prior, [LawChoice.usual(Contaminated())], rng).law
    except InvalidInputError:
        return None
    assert isinstance(law, Contaminated)
    return law


def _verdicts(problem: RecordingProblem, draws: Draws) -> tuple[Verdict, ...]:
    found = []
    for name, limit in problem.setup.limits.items():
        size = np.abs(draws.flat[:, problem.model.numbers[name]])
        exceeds = float((size > limit).mean())
        found.append(Verdict(name=name, limit=float(limit), probability=exceeds))
    return tuple(found)
