"""The posterior under the law chosen, its mode and its draws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.noise import NoiseLaw
from probreg.posterior.posterior import Posterior
from probreg.problems.linear import LinearProblem
from probreg.registration._choice import Chosen
from probreg.registration._fit import settle
from probreg.registration._identities import Identified
from probreg.samplers import PARETO_K, Draws, Gibbs, Importance, MetropolisHastings
from probreg.typing import FloatArray

CHAIN_ROWS = 2_000  # up to which chains are cheap; beyond, importance sampling, if it can
MANY_ROWS = 20_000  # beyond which chains take too long
_CHAINS = 4


class Fitted(NamedTuple):
    """The mode under the law chosen, and the posterior of the rows linearised there.

    Attributes
    ----------
    law : NoiseLaw
        Its parameters at the values of the comparison of laws.
    theta : ndarray, shape (p,)
    linear : LinearProblem
    posterior : Posterior
        The law's parameters unknown.
    """

    law: NoiseLaw
    theta: FloatArray
    linear: LinearProblem
    posterior: Posterior


def fit(known: Identified, chosen: Chosen) -> Fitted:
    """Find the mode of all rows under the law chosen."""
    law, prior = chosen.law, known.prior
    theta, linear = settle(known.problem, law, prior, known.theta, near=True)
    posterior = Posterior(linear, chosen.choice.law, prior, chosen.choice.unknown)
    return Fitted(law=law, theta=theta, linear=linear, posterior=posterior)


def draw(posterior: Posterior, num_draws: int, rng: np.random.Generator) -> Draws:
    """Importance sampling where rows are many and it can, chains otherwise."""
    rows = len(posterior.rows.size)
    a_chain = -(-num_draws // _CHAINS)
    if rows > CHAIN_ROWS:
        draws = Importance(oversample=1.0).sample(posterior, a_chain, _CHAINS, rng)
        if draws.facts["pareto_k"] <= PARETO_K or rows > MANY_ROWS:
            return draws
    sampler = Gibbs(walks=8) if posterior.noise.scale_mixture else MetropolisHastings()
    return sampler.sample(posterior, a_chain, _CHAINS, rng)
