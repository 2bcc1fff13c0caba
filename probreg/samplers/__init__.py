"""Samplers, one a module, each a frozen dataclass of its settings."""

from probreg.samplers._base import PARETO_K, BaseDraws
from probreg.samplers._draws import Draws, Sampler
from probreg.samplers.exact import Exact
from probreg.samplers.gibbs import Gibbs
from probreg.samplers.importance import Importance
from probreg.samplers.metropolis_hastings import MetropolisHastings
from probreg.samplers.nuts import Nuts

__all__ = [
    "PARETO_K",
    "BaseDraws",
    "Draws",
    "Exact",
    "Gibbs",
    "Importance",
    "MetropolisHastings",
    "Nuts",
    "Sampler",
]
