"""What speaks for and against a fit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.noise import NoiseLaw
from probreg.posterior import WeightedFit
from probreg.posterior.posterior import Posterior
from probreg.prior import GaussianPrior
from probreg.problems.linear import LinearProblem
from probreg.registration._accuracy import Accuracy, accuracies
from probreg.registration._choice import law_at
from probreg.registration._clusters import cluster_ratio
from probreg.registration._identities import Identified
from probreg.registration._observed import Determined, determined
from probreg.registration._posterior import Fitted
from probreg.registration.residuals import Residuals, report_residuals
from probreg.samplers import Draws
from probreg.typing import FloatArray


class Checks(NamedTuple):
    """What the data determine, how noisy the reports are, whether their errors hang together.

    Attributes
    ----------
    determined : Determined
    noise_scale : tuple of float
    residuals : Residuals
        Of single reports at the posterior mean.
    accuracies : list of Accuracy
    cluster_ratio : ndarray, shape (p,)
    """

    determined: Determined
    noise_scale: tuple[float, float]
    residuals: Residuals
    accuracies: list[Accuracy]
    cluster_ratio: FloatArray


def check(known: Identified, fitted: Fitted, draws: Draws) -> Checks:
    """Look at the fit from every side; see `Registration` for what each number means."""
    problem, prior = known.problem, known.prior
    linear, law, theta = fitted.linear, fitted.law, fitted.theta
    p = len(theta)
    found = report_residuals(problem.recording, problem.setup, draws.flat[:, :p].mean(axis=0))
    return Checks(
        determined=determined(linear, _information(linear, law, prior), prior),
        noise_scale=noise_scale(fitted.posterior, draws),
        residuals=found,
        accuracies=accuracies(problem.recording, problem.setup, found),
        cluster_ratio=cluster_ratio(
            linear, law, problem.plan.target, theta, draws.covariance[:p, :p]
        ),
    )


def noise_scale(posterior: Posterior, draws: Draws) -> tuple[float, float]:
    """Standard deviation of the bulk of the rows and of all, over what is declared.

    The second counts heavy tails and outliers: scale times sqrt(nu / (nu - 2)), or that of the
    mixture; infinite where the law has no variance. (1, 1) where the scale is not unknown.
    """
    if f"noise.{posterior.noise.unit_name}" not in draws.names:
        return 1.0, 1.0
    law = law_at(posterior, posterior.free(np.median(draws.flat, axis=0)))
    return float(law.unit), float(np.sqrt(law.covariance_factor(2)))


def _information(linear: LinearProblem, law: NoiseLaw, prior: GaussianPrior) -> FloatArray:
    fit = WeightedFit(linear, law, prior)
    return fit.normal_matrix(linear.whitened(), fit.mode().weights) - prior.precision
