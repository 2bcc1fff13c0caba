"""A bias that several recordings share, but not exactly: common value and deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from probreg.errors import InvalidInputError
from probreg.numerics.intervals import equal_tailed
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_number, whole_number

_GRID = 4000  # points at which the spread between recordings is looked at


@dataclass(frozen=True, eq=False)
class Pooled:
    """Posterior draws of one bias over several recordings.

    Attributes
    ----------
    common : ndarray, shape (k,)
        Mean of the population that the recordings are from.
    spread : ndarray, shape (k,)
        Standard deviation between recordings.
    each : ndarray, shape (k, n)
        The bias of each recording.
    new : ndarray, shape (k,)
        That of a recording not yet made: what a correction by the others has to reckon with.
    """

    common: FloatArray
    spread: FloatArray
    each: FloatArray
    new: FloatArray

    def interval(self, probability: float) -> FloatArray:
        """Equal-tailed intervals of common, spread and new, shape (3, 2)."""
        draws = np.stack([self.common, self.spread, self.new], axis=1)
        return equal_tailed(draws, probability, (0,))


def pool(
    mean: FloatArray,
    sd: FloatArray,
    *,
    common_sd: float,
    spread_sd: float,
    num_draws: int,
    rng: np.random.Generator,
) -> Pooled:
    """Pool the posteriors of one bias in n recordings, each about normal under a flat prior.

    theta_i ~ N(common, spread^2), common ~ N(0, common_sd^2), spread half-normal of scale
    spread_sd. The spread is drawn from its marginal on a fine grid of its logarithm, the rest
    given it in closed form, so draws are independent.

    Parameters
    ----------
    mean, sd : ndarray, shape (n,)
        Of each recording's posterior.
    common_sd, spread_sd : float
        In the bias's unit.
    num_draws : int
    rng : numpy.random.Generator

    Raises
    ------
    InvalidInputError
        Fewer than two recordings, numbers that are not finite or not above zero, no draw.
    """
    mean = finite_array("mean", mean, (None,))
    sd = finite_array("sd", sd, (len(mean),))
    if len(mean) < 2:
        raise InvalidInputError("one recording says nothing of the spread between recordings.")
    if np.any(sd <= 0.0):
        raise InvalidInputError(f"sd of recording {int(np.argmin(sd))} is not above zero.")
    positive_number("common_sd", common_sd)
    positive_number("spread_sd", spread_sd)
    whole_number("num_draws", num_draws)
    log_grid = _log_grid(mean, sd, spread_sd)
    grid = np.exp(log_grid)
    centre, variance, value = _given_spread(mean, sd, grid, common_sd)
    log_weight = value - 0.5 * (grid / spread_sd) ** 2 + log_grid
    chosen = rng.choice(_GRID, num_draws, p=np.exp(log_weight - logsumexp(log_weight)))
    spread = grid[chosen] * np.exp((log_grid[1] - log_grid[0]) * (rng.random(num_draws) - 0.5))
    common = centre[chosen] + np.sqrt(variance[chosen]) * rng.standard_normal(num_draws)
    precision = 1.0 / sd**2 + 1.0 / spread[:, None] ** 2
    middle = (mean / sd**2 + common[:, None] / spread[:, None] ** 2) / precision
    each = middle + rng.standard_normal(middle.shape) / np.sqrt(precision)
    new = common + spread * rng.standard_normal(num_draws)
    return Pooled(common=common, spread=spread, each=each, new=new)


def _log_grid(mean: FloatArray, sd: FloatArray, spread_sd: float) -> FloatArray:
    """Logarithms of the spreads that are looked at."""
    # below the first point the spread is nothing beside any sd, above the last the prior is
    least = 1e-3 * min(float(sd.min()), spread_sd)
    most = max(8.0 * spread_sd, 10.0 * float(np.ptp(mean)))
    return np.linspace(np.log(least), np.log(most), _GRID)


def _given_spread(
    mean: FloatArray, sd: FloatArray, spread: FloatArray, common_sd: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean and variance of the common value given each spread (k,), and its log-likelihood."""
    total = sd**2 + spread[:, None] ** 2
    precision = (1.0 / total).sum(axis=1) + 1.0 / common_sd**2
    centre = (mean / total).sum(axis=1) / precision
    value = -0.5 * np.log(total).sum(axis=1) - 0.5 * np.log(precision)
    value -= 0.5 * ((mean**2 / total).sum(axis=1) - centre**2 * precision)
    return centre, 1.0 / precision, value
