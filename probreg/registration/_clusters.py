"""Whether errors of one target's reports hang together more than the noise law has it."""

from __future__ import annotations

import numpy as np

from probreg.posterior.tracks import TrackFit, bias_scores, telling_targets
from probreg.typing import FloatArray

FEWEST_TARGETS = 10  # below, a sum over targets says next to nothing about its own spread


def cluster_ratio(fit: TrackFit) -> FloatArray:
    """Standard deviations by the targets' scores, relative to those of the posterior.

    The sandwich V J V with V the posterior covariance and J the sum over targets of the outer
    products of their scores: reports of one target may depend on each other in any way.

    Returns
    -------
    ndarray, shape (p,)
        About one where errors are independent; NaN with fewer than ten targets.
    """
    tell = telling_targets(fit)
    if len(tell) < FEWEST_TARGETS:
        return np.full(fit.knots.num_biases, np.nan)
    moved = fit.knots.averages(bias_scores(fit)[tell] @ fit.covariance)
    variance = len(tell) / (len(tell) - 1.0) * np.einsum("gp,gp->p", moved, moved)
    return np.asarray(np.sqrt(variance / np.diag(fit.bias_covariance)))
