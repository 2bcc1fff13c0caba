"""Biases that drift: how far they move is unknown, and found from what all reports say of them.

Coefficients are prior mean + B z with z standard normal: a column of B for each level, which stays,
and for each part of a deviation (`Drift.root`). So a spread may be zero, and nothing is inverted
that is not well conditioned.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy import linalg

from probreg.errors import InvalidInputError
from probreg.prior import GaussianPrior
from probreg.problems.recording.knots import Knots
from probreg.sensors.drifts import Drift
from probreg.typing import FloatArray
from probreg.validation import finite_array

DECADES, POINTS = 2.0, 97  # of the grid of spreads on either side of the prior's median
CONSTANT = 0.5  # prior probability that a bias that may drift does not
ROUNDS = 3


class Spreads(NamedTuple):
    """How far each drifting bias moves.

    Attributes
    ----------
    spread : ndarray, shape (d,)
        SI units; see `Drift.meaning`.
    precision : tuple of ndarray, shape (m,)
        Of the parts of each bias; one unless their tails are heavy.
    """

    spread: FloatArray
    precision: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class DriftPrior:
    """Prior of the coefficients of biases of which some drift.

    Parameters
    ----------
    level : GaussianPrior
        Of the p levels.
    knots : Knots
    kinds : tuple of Drift
        Of each drifting bias.
    scale : ndarray, shape (d,)
        Prior median of each spread: half-Cauchy, beside a probability of one half that the bias
        does not drift.
    """

    level: GaussianPrior
    knots: Knots
    kinds: tuple[Drift, ...]
    scale: FloatArray
    roots: tuple[FloatArray, ...] = field(init=False, repr=False)
    levels: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        d = len(self.knots.drifting)
        scale = finite_array("scale of drift", self.scale, (d,))
        if len(self.kinds) != d or not d or (scale <= 0.0).any():
            raise InvalidInputError(f"{d} kinds of drift, and scales above zero, are needed.")
        object.__setattr__(self, "scale", scale)
        roots = []
        for bias, kind in zip(self.knots.drifting, self.kinds, strict=True):
            root = kind.root(self.knots.time)
            full = np.zeros((self.knots.size, root.shape[1]))
            full[self.knots.places(bias)] = root
            roots.append(full)
        object.__setattr__(self, "roots", tuple(roots))
        levels = self.knots.constant @ np.linalg.cholesky(self.level.covariance)
        object.__setattr__(self, "levels", levels)

    @property
    def mean(self) -> FloatArray:
        """Of the coefficients, (P,)."""
        return np.asarray(self.knots.constant @ self.level.mean)

    @property
    def usual(self) -> Spreads:
        """The prior medians, and parts that are normal."""
        return Spreads(self.scale, tuple(np.ones(root.shape[1]) for root in self.roots))

    def part(self, j: int, spreads: Spreads) -> FloatArray:
        """Columns (P, m) of drifting bias j at a spread of one."""
        return np.asarray(self.roots[j] / np.sqrt(spreads.precision[j]))

    def root(self, spreads: Spreads, without: int = -1) -> FloatArray:
        """B, shape (P, columns); without those of one drifting bias."""
        parts = [
            spreads.spread[j] * self.part(j, spreads)
            for j in range(len(self.roots))
            if j != without and spreads.spread[j] > 0.0
        ]
        return np.hstack([self.levels, *parts])

    def grid(self, j: int) -> tuple[FloatArray, FloatArray]:
        """Spreads of drifting bias j, from zero up, and their log prior probabilities."""
        x = np.logspace(-DECADES, DECADES, POINTS)
        share = x / (1.0 + x**2)
        log_share = np.log((1.0 - CONSTANT) * share / share.sum())
        return (
            np.concatenate([[0.0], self.scale[j] * x]),
            np.concatenate([[np.log(CONSTANT)], log_share]),
        )


class Evidence(NamedTuple):
    """Log likelihood of coefficients x beyond the prior mean: constant + b.x - x'J x / 2."""

    J: FloatArray
    b: FloatArray
    constant: float

    @classmethod
    def at(
        cls, prior: DriftPrior, J: FloatArray, eta: FloatArray, theta: FloatArray, ll: float
    ) -> Evidence:
        """From information about coefficients counted from theta."""
        x = theta - prior.mean
        return cls(J, eta + J @ x, float(ll - eta @ x - 0.5 * x @ J @ x))


class Coefficients(NamedTuple):
    """All coefficients given the spreads.

    Attributes
    ----------
    mean : ndarray, shape (P,)
    root : ndarray, shape (P, columns)
        Times its transpose their covariance.
    log_marginal : float
    """

    mean: FloatArray
    root: FloatArray
    log_marginal: float

    @property
    def covariance(self) -> FloatArray:
        """Shape (P, P)."""
        return np.asarray(self.root @ self.root.T)

    def draw(self, rng: np.random.Generator, count: int) -> FloatArray:
        """Independent draws, shape (count, P)."""
        z = rng.standard_normal((count, self.root.shape[1]))
        return np.asarray(self.mean + z @ self.root.T)


def coefficients(prior: DriftPrior, evidence: Evidence, spreads: Spreads) -> Coefficients:
    """Exact posterior given the spreads."""
    B = prior.root(spreads)
    L = _factor(B, evidence.J)
    u = linalg.solve_triangular(L, B.T @ evidence.b, lower=True)
    root = linalg.solve_triangular(L, B.T, lower=True).T
    log_marginal = evidence.constant + 0.5 * float(u @ u) - float(np.log(np.diag(L)).sum())
    return Coefficients(prior.mean + root @ u, root, log_marginal)


def _factor(B: FloatArray, J: FloatArray) -> FloatArray:
    """Cholesky factor of I + B'JB."""
    return np.linalg.cholesky(np.eye(B.shape[1]) + B.T @ J @ B)


class Profile(NamedTuple):
    """What all reports say of the spread of one bias, everything else integrated out.

    Attributes
    ----------
    spread : ndarray, shape (g,)
        From zero up.
    log_density : ndarray, shape (g,)
        Of the reports; zero at a spread of zero.
    log_posterior : ndarray, shape (g,)
        Normalised.
    """

    spread: FloatArray
    log_density: FloatArray
    log_posterior: FloatArray

    @property
    def constant(self) -> float:
        """Probability that the bias does not drift."""
        return float(np.exp(self.log_posterior[0]))

    @property
    def best(self) -> float:
        """The most probable spread above zero."""
        return float(self.spread[1 + np.argmax(self.log_posterior[1:])])


def others_out(
    prior: DriftPrior, evidence: Evidence, spreads: Spreads, j: int
) -> tuple[FloatArray, FloatArray]:
    """Information (m, m) and shift (m,) about the parts of bias j, all others integrated out."""
    R, B = prior.part(j, spreads), prior.root(spreads, without=j)
    JR = evidence.J @ R
    L = _factor(B, evidence.J)
    taken = linalg.solve_triangular(L, B.T @ JR, lower=True)
    pull = linalg.solve_triangular(L, B.T @ evidence.b, lower=True)
    return R.T @ JR - taken.T @ taken, R.T @ evidence.b - taken.T @ pull


def profile(prior: DriftPrior, evidence: Evidence, spreads: Spreads, j: int) -> Profile:
    """Exact marginal likelihood of one spread on its grid, from one decomposition."""
    A, c = others_out(prior, evidence, spreads, j)
    size, vectors = np.linalg.eigh(A)
    size, along = np.maximum(size, 0.0), (vectors.T @ c) ** 2
    spread, log_prior = prior.grid(j)
    square = spread[:, None] ** 2
    gain = square * along / (1.0 + square * size) - np.log1p(square * size)
    log_density = 0.5 * gain.sum(axis=1)
    log_posterior = log_density + log_prior
    return Profile(spread, log_density, log_posterior - np.logaddexp.reduce(log_posterior))


def fit_spreads(prior: DriftPrior, evidence: Evidence, near: Spreads | None = None) -> Spreads:
    """The most probable spreads above zero, each at the others' values in turn."""
    spreads = prior.usual if near is None else near
    for _ in range(ROUNDS if near is None and len(prior.kinds) > 1 else 1):
        for j in range(len(prior.kinds)):
            spread = spreads.spread.copy()
            spread[j] = profile(prior, evidence, spreads, j).best
            spreads = spreads._replace(spread=spread)
    return spreads
