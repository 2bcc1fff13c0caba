"""Samplers, one a module, each a frozen dataclass of its settings."""

from probreg.samplers._draws import PARETO_K, Draws, Sampler
from probreg.samplers.exact import Exact
from probreg.samplers.gibbs import Gibbs
from probreg.samplers.importance import Importance
from probreg.samplers.metropolis_hastings import MetropolisHastings
from probreg.samplers.nuts import Nuts

__all__ = [
    "PARETO_K",
    "Draws",
    "Exact",
    "Gibbs",
    "Importance",
    "MetropolisHastings",
    "Nuts",
    "Sampler",
]
