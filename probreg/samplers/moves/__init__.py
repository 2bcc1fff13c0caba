"""Metropolis-Hastings moves, one a module, each a frozen dataclass of its settings.

A move proposes for many chains at once and gives the log of the ratio of proposal densities,
log q(x | y) - log q(y | x), so that each is accepted by its own Hastings ratio.
"""

from probreg.samplers.moves._move import Move, Proposal
from probreg.samplers.moves.global_uniform import GlobalUniform
from probreg.samplers.moves.laplace_t import LaplaceT
from probreg.samplers.moves.local_gaussian import LocalGaussian

__all__ = ["GlobalUniform", "LaplaceT", "LocalGaussian", "Move", "Proposal"]
