"""Two calibrations of the same sensors: how probably, and by how much, they differ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.special import expit, logsumexp

from probreg.errors import InvalidInputError
from probreg.registration.saved import SavedResult, ordered, refuse_others
from probreg.typing import FloatArray

# standard deviations of a change, by unit: as likely each, SI
CHANGES: Mapping[str, tuple[float, ...]] = {
    "m": (15.0, 50.0, 150.0),
    "rad": tuple(np.deg2rad([0.03, 0.1, 0.3]).tolist()),
    "s": (0.03, 0.1, 0.3),
    "m/m": (1e-4, 3e-4, 1e-3),
    "": (1e-3, 3e-3, 1e-2),
}


@dataclass(frozen=True, eq=False)
class Differences:
    """New less old, of each bias, SI units.

    Attributes
    ----------
    names, units : tuple of str
    old, new : ndarray, shape (p,)
        Means.
    mean, sd : ndarray, shape (p,)
        Of the difference.
    covariance : ndarray, shape (p, p)
    differs : ndarray, shape (p,)
        Probability that the bias changed at all, given that it did with one half.
    limits, exceeds : ndarray, shape (p,)
        Largest change that is acceptable, and the probability that it is larger; NaN without.
    chi2 : float
        Squared difference in units of its covariance, all biases together.
    p_value : float
        Probability of a larger one if nothing changed.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    old: FloatArray
    new: FloatArray
    mean: FloatArray
    sd: FloatArray
    covariance: FloatArray
    differs: FloatArray
    limits: FloatArray
    exceeds: FloatArray
    chi2: float
    p_value: float

    def interval(self, probability: float = 0.9) -> FloatArray:
        """Equal-tailed intervals (p, 2) of the differences."""
        wide = stats.norm.ppf(0.5 + 0.5 * probability) * self.sd
        return np.stack([self.mean - wide, self.mean + wide], axis=1)


def compare(
    old: SavedResult, new: SavedResult, limits: Mapping[str, float] | None = None
) -> Differences:
    """Compare two results from different recordings.

    The posteriors are taken as normal and independent. Both hold the same prior, which draws
    biases that the data hardly determine together: what is said of those is cautious.

    Parameters
    ----------
    old, new : SavedResult
    limits : mapping of str to float, optional
        Largest acceptable change by name, or by term for every sensor, SI units; by default the
        limit of the bias itself.

    Raises
    ------
    InvalidInputError
        Other sensors or terms, a limit of a bias that is not there.
    """
    refuse_others([old, new])
    new = ordered(new, old.names)
    covariance = old.covariance + new.covariance
    mean = new.mean - old.mean
    sd = np.sqrt(np.diag(covariance))
    bound = _limits(old, new, limits or {})
    try:
        chi2 = float(mean @ np.linalg.solve(covariance, mean))
    except np.linalg.LinAlgError:
        raise InvalidInputError(
            "the covariance of the biases is singular; register again with more draws."
        ) from None
    exceeds = stats.norm.sf(bound, mean, sd) + stats.norm.cdf(-bound, mean, sd)
    return Differences(
        old.names,
        old.units,
        old.mean,
        new.mean,
        mean,
        sd,
        covariance,
        np.array([_differs(*one) for one in zip(mean, sd, old.units, strict=True)]),
        bound,
        exceeds,
        chi2,
        float(stats.chi2.sf(chi2, len(mean))),
    )


def _differs(mean: float, sd: float, unit: str) -> float:
    """Probability of a change against none, equally likely before, by the marginal likelihoods."""
    spread = np.hypot(sd, CHANGES[unit])
    changed = logsumexp(stats.norm.logpdf(mean, 0.0, spread)) - np.log(len(spread))
    return float(expit(changed - stats.norm.logpdf(mean, 0.0, sd)))


def _limits(old: SavedResult, new: SavedResult, given: Mapping[str, float]) -> FloatArray:
    """Limits (p,) of the changes."""
    terms = [name.split(".", 1)[1] for name in old.names]
    strange = sorted(set(given) - set(old.names) - set(terms))
    if strange:
        raise InvalidInputError(
            f"no bias {strange[0]!r} to limit; there are {', '.join(old.names)}."
        )
    own = np.where(np.isnan(new.limits), old.limits, new.limits)
    return np.array(
        [
            given.get(name, given.get(term, limit))
            for name, term, limit in zip(old.names, terms, own.tolist(), strict=True)
        ]
    )
