"""Which noise law the rows follow, by leave-one-out."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from probreg.diagnostics import Ranked, compare_laws
from probreg.errors import InvalidInputError
from probreg.noise import NoiseLaw
from probreg.posterior.posterior import Posterior
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem
from probreg.registration._fit import some_rows, thinned
from probreg.registration._identities import Identified
from probreg.registration._laws import LawChoice
from probreg.samplers import Importance
from probreg.typing import FloatArray

LAW_ROWS = 2_000  # for the comparison of laws
_DRAWS, _CHAINS = 100, 4


class Chosen(NamedTuple):
    """The law chosen, its parameters at their modes, and the competition.

    Attributes
    ----------
    choice : LawChoice
    fitted : dict of str to NoiseLaw
        Every law at its mode.
    ranked : tuple of Ranked
    rows : int
        Rows that the comparison is of.
    notes : list of str
    """

    choice: LawChoice
    fitted: dict[str, NoiseLaw]
    ranked: tuple[Ranked, ...]
    rows: int
    notes: list[str]

    @property
    def law(self) -> NoiseLaw:
        """The law chosen, at its mode."""
        return self.fitted[self.choice.name]


def choose(known: Identified, laws: Sequence[LawChoice], rng: np.random.Generator) -> Chosen:
    """Rank laws on some rows, evenly spread, at the provisional biases; see `choose_law`."""
    linear = known.problem.linearise(known.theta)
    some = thinned(len(known.problem.plan), LAW_ROWS)
    return choose_law(some_rows(linear, some), known.prior, laws, rng)


def choose_law(
    linear: LinearProblem,
    prior: GaussianPrior,
    laws: Sequence[LawChoice],
    rng: np.random.Generator,
) -> Chosen:
    """Rank laws on the rows given and fit the parameters of each.

    Raises
    ------
    InvalidInputError
        No law, a name twice, or none of them can be fitted.
    """
    by_name = {choice.name: choice for choice in laws}
    if not laws or len(by_name) < len(laws):
        raise InvalidInputError(f"laws must be different, one at least: {[c.name for c in laws]}.")
    draws, fitted, notes = {}, {}, []
    for name, choice in by_name.items():
        posterior = Posterior(linear, choice.law, prior, choice.unknown)
        try:
            fitted[name] = law_at(posterior, posterior.laplace.mean)
            if len(laws) > 1:
                sampler = Importance(oversample=2.0)
                draws[name] = sampler.sample(posterior, _DRAWS, _CHAINS, rng)
        except InvalidInputError as error:
            fitted.pop(name, None)
            notes.append(f"the law {name} could not be fitted and is left out: {error}")
    if not fitted:
        raise InvalidInputError("no noise law could be fitted: " + " ".join(notes))
    alone = Ranked(next(iter(fitted)), np.nan, 0.0, 0.0, 0)
    ranked = compare_laws(draws) if len(draws) > 1 else [alone]
    return Chosen(
        choice=by_name[ranked[0].name],
        fitted=fitted,
        ranked=tuple(ranked),
        rows=len(linear.y),
        notes=notes,
    )


def law_at(posterior: Posterior, x: FloatArray) -> NoiseLaw:
    """The law at free coordinates (d,), every parameter one number."""
    values = posterior.natural(x)[posterior.dim_theta :]
    changed = {p.name: float(v) for p, v in zip(posterior.noise_prior, values, strict=True)}
    return dataclasses.replace(posterior.noise, **changed)  # type: ignore[type-var]
