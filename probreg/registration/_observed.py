"""What the data determine, and what only the prior or a reference does."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from probreg.posterior.tracks import TrackFit
from probreg.prior import GaussianPrior
from probreg.problems.observability import Observability, observability_of_information
from probreg.typing import FloatArray

WEAK = 1.0  # information of the data over that of the prior, below which the prior decides
SMALL = 0.05  # parts of a combination that would only clutter its name, of the largest


@dataclass(frozen=True, eq=False)
class Determined:
    """Which combinations of the biases the data determine.

    Attributes
    ----------
    names : tuple of str
    observability : Observability
        Of the data alone.
    hidden : list of str
        Combinations that no residual shows, in prior standard deviations of each bias.
    weak : list of str
        Combinations that the prior determines more than the data, hidden ones included.
    share : ndarray, shape (p,)
        Of the prior variance of each bias that the data remove: 1 is all, 0 nothing.
    """

    names: tuple[str, ...]
    observability: Observability
    hidden: list[str]
    weak: list[str]
    share: FloatArray


def determined_by(fit: TrackFit, names: tuple[str, ...]) -> Determined:
    """Compare what tracks say with the prior; of biases that drift, of their levels."""
    knots = fit.knots
    information = fit.information.precision
    together = fit.model.all_clocks
    if together is not None:
        free = np.eye(len(together)) - np.outer(together, together)
        information = free @ information @ free
    if knots.drifting:
        information = knots.constant.T @ information @ knots.constant
    found = determined(information, fit.model.prior, names, len(fit.point.tangent.equations.y))
    if not knots.drifting:
        return found
    share = 1.0 - np.diag(fit.bias_covariance) / np.diag(fit.model.prior.covariance)
    return replace(found, share=np.clip(share, 0.0, 1.0))


def determined(
    information: FloatArray, prior: GaussianPrior, names: tuple[str, ...], equations: int
) -> Determined:
    """Compare the information (p, p) of the data with that of the prior.

    Parameters
    ----------
    information : ndarray, shape (p, p)
        Of the data alone, under the law chosen.
    prior : GaussianPrior
    names : tuple of str
    equations : int
        Scalar equations that the information is from.
    """
    found = observability_of_information(information, names, equations)
    root = np.linalg.cholesky(prior.covariance)
    ratio, vectors = np.linalg.eigh(root.T @ information @ root)
    weak = (root @ vectors[:, ratio < WEAK]).T
    posterior = np.linalg.inv(information + prior.precision)
    share = 1.0 - np.diag(posterior) / np.diag(prior.covariance)
    hidden, weak = (_spelt(one, found, prior) for one in (found.null_space, weak))
    return Determined(names, found, hidden, weak, share)


def _spelt(rows: FloatArray, found: Observability, prior: GaussianPrior) -> list[str]:
    """Combinations (k, p) written out in prior standard deviations, small parts left out."""
    # metres beside radians say nothing of which part is large
    scaled = rows / np.sqrt(np.diag(prior.covariance))
    size = np.abs(scaled).max(axis=1, keepdims=True, initial=0.0)
    kept = np.where(np.abs(scaled) > SMALL * size, scaled, 0.0)
    return Observability(found.singular_values, kept, found.names, found.equations).combinations()
