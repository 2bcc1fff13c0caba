"""Where a problem, a noise law and priors meet."""

from probreg.posterior.laplace import Laplace
from probreg.posterior.path_posterior import PathPosterior
from probreg.posterior.posterior import Posterior
from probreg.posterior.reweighting import Mode, Reweighted
from probreg.prior import GaussianPrior, NoiseParameter

__all__ = [
    "GaussianPrior",
    "Laplace",
    "Mode",
    "NoiseParameter",
    "PathPosterior",
    "Posterior",
    "Reweighted",
]
