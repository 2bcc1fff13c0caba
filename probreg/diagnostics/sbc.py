"""Simulation-based calibration: draw the truth from the prior, then rank it among the draws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple, Protocol

import numpy as np
from scipy.special import bdtr, bdtrc

from probreg.diagnostics.coverage import Coverage
from probreg.errors import InvalidInputError
from probreg.posterior.posterior import Posterior
from probreg.samplers import Draws, Sampler
from probreg.typing import FloatArray, IntArray
from probreg.validation import open_share

_GRID = 50  # points at which the empirical distribution is held against the uniform one
_SIMULATIONS = 4000
_SEED = 7919  # of the simulated null distribution: the same band for the same sizes


class Case(NamedTuple):
    """One replicate: a posterior, and the free coordinates (d,) that its data came from."""

    posterior: Posterior
    truth: FloatArray


Family = Callable[[np.random.Generator], Case]


class Quantity(Protocol):
    """A test quantity: a number for each of many free coordinates (..., d) under a posterior."""

    def __call__(self, posterior: Posterior, x: FloatArray) -> FloatArray:
        """Values, shape (...)."""


def log_likelihood(posterior: Posterior, x: FloatArray) -> FloatArray:
    """The log-likelihood: it detects errors visible in no single unknown (Modrak et al. 2023)."""
    return posterior.likelihood_and_grad(x)[0]


@dataclass(frozen=True, eq=False)
class Ranks:
    """Ranks of the truth among draws, uniform on 0 .. draws if the sampler is right.

    Attributes
    ----------
    ranks : ndarray of int, shape (replicates, q)
    draws : int
        Number of draws that the truth was ranked among.
    names : tuple of str
        Of the q test quantities.
    """

    ranks: IntArray
    draws: int
    names: tuple[str, ...]

    def histogram(self, name: str, bins: int = 20) -> tuple[FloatArray, FloatArray]:
        """Edges (bins + 1,) and counts (bins,) of the ranks, in units of draws + 1."""
        ranks = self.ranks[:, self.names.index(name)]
        edges = np.linspace(0.0, self.draws + 1.0, bins + 1) - 0.5
        counts, _ = np.histogram(ranks, edges)
        return (edges + 0.5) / (self.draws + 1.0), counts

    def ecdf_difference(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Points z and the empirical distribution of the ranks there, minus z."""
        z = self.points
        share = np.sort(self.ranks[:, self.names.index(name)] + 1.0) / (self.draws + 1.0)
        return z, np.searchsorted(share, z + 1e-12, side="right") / len(share) - z

    @cached_property
    def points(self) -> FloatArray:
        """Points at which the distribution is evaluated: multiples of 1 / (draws + 1)."""
        steps = np.unique(np.linspace(1, self.draws, min(_GRID, self.draws)).astype(int))
        return steps / (self.draws + 1.0)

    def band(self, false_alarm: float = 0.05) -> tuple[FloatArray, FloatArray]:
        """Simultaneous limits (lower, upper) of the ECDF difference at the points.

        A correct sampler leaves them anywhere with this probability.
        """
        n = len(self.ranks)
        gamma = float(np.quantile(self._null, false_alarm))
        counts = np.arange(n + 1.0)
        low, high = np.empty_like(self.points), np.empty_like(self.points)
        for k, z in enumerate(self.points):
            below = bdtr(counts, n, z)
            low[k] = np.searchsorted(below, 0.5 * gamma, side="right")
            high[k] = np.searchsorted(below, 1.0 - 0.5 * gamma, side="left")
        return low / n - self.points, high / n - self.points

    @cached_property
    def p_values(self) -> FloatArray:
        """Probability, under uniform ranks, of as large an ECDF deviation anywhere, shape (q,).

        Below one in a hundred it is extrapolated: the least tail probability of so many points
        falls below a small bound about in proportion to that bound.
        """
        null, columns = self._null, self.ranks.T
        found = np.array([_least_tail(column + 1, self.draws, self.points) for column in columns])
        simulated = (1.0 + (null[None, :] <= found[:, None]).sum(axis=1)) / (1.0 + null.size)
        rare = float(np.quantile(null, 0.01))
        return np.where(found < rare, 0.01 * found / rare, simulated)

    def require(self, false_alarm: float = 1e-3) -> None:
        """Raise unless no quantity is off, at a family-wise false-alarm rate.

        Raises
        ------
        InvalidInputError
            Names the quantities that are off.
        """
        bad = self.p_values < false_alarm / len(self.names)
        if bad.any():
            listing = ", ".join(
                f"{name} (p = {p:.2g})"
                for name, p, wrong in zip(self.names, self.p_values, bad, strict=True)
                if wrong
            )
            raise InvalidInputError(f"not calibrated: {listing}.")

    def coverage(self, nominal: float) -> list[Coverage]:
        """Coverage of central intervals of each quantity, from the ranks alone.

        Interval ends are whole ranks, so the nominal coverage is the nearest attainable one.

        Raises
        ------
        InvalidInputError
            A nominal coverage out of (0, 1), or too few draws: no rank lies outside the interval,
            or none inside.
        """
        tail = 0.5 * (1.0 - open_share("nominal", nominal)) * (self.draws + 1.0)
        low, high = round(tail), round(self.draws + 1.0 - tail)
        if not 0 < low < high:
            raise InvalidInputError(
                f"ranks among {self.draws} draws are too coarse for intervals of {nominal:.4g}: "
                f"they would hold {'every' if low < 1 else 'no'} rank. Keep more draws (keep) or "
                "ask for another nominal coverage."
            )
        held = (self.ranks >= low) & (self.ranks < high)
        actual = (high - low) / (self.draws + 1.0)
        return [Coverage(int(column.sum()), len(column), actual) for column in held.T]

    @cached_property
    def _null(self) -> FloatArray:
        """The least pointwise tail probability of uniform ranks, simulated."""
        return _null_tails(len(self.ranks), self.draws, tuple(self.points))


@cache
def _null_tails(n: int, draws: int, points: tuple[float, ...]) -> FloatArray:
    """Least tail probabilities of n uniform ranks, simulated once for each pair of sizes."""
    rng = np.random.default_rng(_SEED)
    z = np.array(points)
    tails = [_least_tail(rng.integers(1, draws + 2, n), draws, z) for _ in range(_SIMULATIONS)]
    return np.array(tails)


def _least_tail(ranks: IntArray, draws: int, points: FloatArray) -> float:
    """Smallest two-sided binomial probability of the ECDF over the points; ranks from 1."""
    share = np.sort(ranks) / (draws + 1.0)
    count = np.searchsorted(share, points + 1e-12, side="right").astype(float)
    n = len(ranks)
    below, above = bdtr(count, n, points), np.where(count > 0, bdtrc(count - 1, n, points), 1.0)
    return float(2.0 * np.minimum(below, above).min())


def rank_truth(
    draws: Draws, truth: FloatArray, keep: int, rng: np.random.Generator
) -> tuple[IntArray, tuple[str, ...]]:
    """Ranks (d + 1,) of the true free coordinates, and of their log-likelihood, among `keep` draws.

    The draws kept are evenly spaced: one from each chain where there are as many chains, every
    third of one chain where it has three times as many. Ties are broken at random.

    Raises
    ------
    InvalidInputError
        Fewer draws than `keep`.
    """
    total = draws.theta.shape[0] * draws.theta.shape[1]
    if total < keep:
        raise InvalidInputError(
            f"{total} draws are too few to rank the truth among {keep}; draw more or keep fewer."
        )
    ordered = np.swapaxes(draws.theta, 0, 1).reshape(total, -1)  # draw by draw, all chains
    at = total - 1 - (total // keep) * np.arange(keep)
    x = draws.posterior.free(ordered[at])
    values = np.column_stack([x, log_likelihood(draws.posterior, x)])
    true = np.append(truth, log_likelihood(draws.posterior, truth))
    less, equal = (values < true).sum(axis=0), (values == true).sum(axis=0)
    return less + rng.integers(0, equal + 1), (*draws.names, "log_likelihood")


def calibrate(
    family: Family,
    sampler: Sampler,
    replicates: int,
    rng: np.random.Generator,
    keep: int = 99,
    num_draws: int = 1,
    num_chains: int = 99,
) -> Ranks:
    """Simulation-based calibration of a sampler on a family of posteriors.

    For samplers whose chains advance together, use as many chains as draws are kept, with one
    draw each after warm-up: the ranks then need no thinning.

    Parameters
    ----------
    family : callable
        Draws a truth from the prior and data from the model: rng -> Case.
    sampler : Sampler
    replicates : int
    rng : numpy.random.Generator
    keep : int
        Draws that the truth is ranked among.
    num_draws, num_chains : int
        As for the sampler.

    Returns
    -------
    Ranks
    """
    if replicates < 1 or keep < 1:
        raise InvalidInputError(f"replicates {replicates} and keep {keep} must be 1 or more.")
    found = []
    names: tuple[str, ...] = ()
    for _ in range(replicates):
        case = family(rng)
        draws = sampler.sample(case.posterior, num_draws, num_chains, rng)
        ranks, names = rank_truth(draws, case.truth, keep, rng)
        found.append(ranks)
    return Ranks(np.array(found), keep, names)
