"""Where a problem, a noise law and priors meet."""

from probreg.posterior.density import Density
from probreg.posterior.laplace import Laplace
from probreg.posterior.path_posterior import PathPosterior
from probreg.posterior.posterior import Posterior
from probreg.posterior.weighted_fit import Mode, WeightedFit
from probreg.prior import GaussianPrior, NoiseParameter

__all__ = [
    "Density",
    "GaussianPrior",
    "Laplace",
    "Mode",
    "NoiseParameter",
    "PathPosterior",
    "Posterior",
    "WeightedFit",
]
