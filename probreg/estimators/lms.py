"""Least median of squares over elemental subsets, raw and reweighted."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb
from typing import ClassVar, Literal

import numpy as np
from scipy.special import chdtri

from probreg.errors import InvalidInputError
from probreg.estimators._estimate import Estimate
from probreg.noise import Gaussian
from probreg.posterior import Posterior, spd_inverse
from probreg.prior import GaussianPrior
from probreg.problem import Problem, Whitened
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import positive_number

_CHUNK = 4_000_000  # residuals held at once


@dataclass(frozen=True)
class Lms:
    """Least median of squared whitened residuals, by random or exhaustive subsets of rows.

    Every subset that just determines the unknowns gives a candidate; the one with the least
    median wins ("raw"). Reweighted, it is followed by least squares on the rows within the
    97.5 % point of the chi-square law, at the scale s of the median with the small-sample
    factor 1 + 5 / (n - p).

    Parameters
    ----------
    unit : {"row", "equation"}
        What the median runs over: the squared norm of rows, or of single components.
    subsets : int
        Number of random subsets; all of them where there are no more than that.
    reweighted : bool
        Whether `theta` is the reweighted solution (with its covariance) or the raw one.

    Raises
    ------
    InvalidInputError
        Unknown unit, fewer than one subset, a prior (the median has no place for it).

    References
    ----------
    Guo et al., Control and Decision (2017), reference [12]; Rousseeuw and Leroy, Robust
    Regression and Outlier Detection, 1987.
    """

    unit: Literal["row", "equation"] = "row"
    subsets: int = 200
    reweighted: bool = True

    takes_prior: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive_number("subsets", self.subsets)
        if int(self.subsets) != self.subsets:
            raise InvalidInputError(f"subsets is {self.subsets}; a whole number is needed.")
        if self.unit not in ("row", "equation"):
            raise InvalidInputError(f"unit is {self.unit!r}; take 'row' or 'equation'.")

    def estimate(
        self,
        problem: Problem,
        prior: GaussianPrior | None = None,
        rng: np.random.Generator | None = None,
    ) -> Estimate:
        """Search the subsets; a nonlinear problem is linearised at zero and at the result.

        Parameters
        ----------
        problem : Problem
        prior : GaussianPrior, optional
            Not taken.
        rng : numpy.random.Generator, optional
            Draws the subsets; needed where there are more than `subsets` of them.

        Returns
        -------
        Estimate
            `weights` are 1 for rows kept and 0 for rows rejected; `info`: "raw", "scale",
            "median", "kept".

        Raises
        ------
        UnobservableError
            The data do not determine every combination.
        """
        if prior is not None:
            raise InvalidInputError("Lms takes no prior; use Irls(noise, start=Lms()) with one.")
        posterior = Posterior(problem, Gaussian())
        rows = problem.linearise(np.zeros(len(problem.names))).whitened()
        p = rows.A.shape[2]
        chosen = self._draw(len(rows.v), p, int(rows.size.min()), rng)
        result = self._search(posterior, rows, chosen)
        if problem.linear:
            return result
        return self._search(posterior, problem.linearise(result.theta).whitened(), chosen)

    def _search(self, posterior: Posterior, rows: Whitened, chosen: IntArray) -> Estimate:
        p = rows.A.shape[2]
        candidates = _solutions(rows, chosen)
        # rows of different length are brought to one scale by the medians of their laws
        m = rows.size if self.unit == "row" else np.ones(int(rows.size.sum()))
        expected = chdtri(m, 0.5)
        parts = _parts(candidates, rows)
        medians = [np.median(self._squares(rows, part) / expected, axis=-1) for part in parts]
        ratios = np.concatenate(medians)
        best = int(np.argmin(ratios))
        raw = candidates[best]
        squares = self._squares(rows, raw)
        scale2 = ratios[best] * (1.0 + 5.0 / max(squares.size - p, 1)) ** 2
        keep = squares <= chdtri(m, 0.025) * max(scale2, np.finfo(float).eps)
        weights = keep.astype(float)
        if self.unit == "equation":
            weights = np.zeros(rows.v.shape)
            weights[_real(rows)] = keep
        theta, covariance = raw, None
        if self.reweighted:
            theta = posterior.solve(rows, weights)
            covariance = scale2 * spd_inverse(posterior.normal_matrix(rows, weights))
        info = {
            "raw": raw,
            "scale": float(np.sqrt(scale2)),
            "median": float(np.median(squares)),
            "kept": int(keep.sum()),
        }
        names, units = posterior.names, posterior.units
        return Estimate(theta, covariance, weights, None, True, info, names, units)

    def _draw(self, n: int, p: int, m: int, rng: np.random.Generator | None) -> IntArray:
        rows_needed = -(-p // m)
        if n < rows_needed:
            raise InvalidInputError(
                f"{n} rows of {m} equations cannot give a subset that determines {p} unknowns."
            )
        if comb(n, rows_needed) <= self.subsets:
            return np.array(list(combinations(range(n), rows_needed)))
        if rng is None:
            raise InvalidInputError(
                f"{comb(n, rows_needed)} subsets are too many to try; pass a Generator "
                "(numpy.random.default_rng(seed)) so that they can be drawn."
            )
        return np.stack([rng.choice(n, rows_needed, replace=False) for _ in range(self.subsets)])

    def _squares(self, rows: Whitened, theta: FloatArray) -> FloatArray:
        v = rows.residual(theta)
        if self.unit == "row":
            return np.einsum("...nm,...nm->...n", v, v)
        return v[..., _real(rows)] ** 2


def _real(rows: Whitened) -> BoolArray:
    return np.arange(rows.v.shape[1]) < rows.size[:, None]


def _solutions(rows: Whitened, chosen: IntArray) -> FloatArray:
    """Least-squares solutions of subsets of rows (k, r), shape (k, p)."""
    p = rows.A.shape[2]
    scale = np.linalg.norm(rows.A.reshape(-1, p), axis=0)
    A = (rows.A[chosen] / scale).reshape(len(chosen), -1, p)
    v = rows.v[chosen].reshape(len(chosen), -1, 1)
    return (np.linalg.pinv(A) @ v)[..., 0] / scale


def _parts(candidates: FloatArray, rows: Whitened) -> list[FloatArray]:
    length = max(1, _CHUNK // rows.v.size)
    return [candidates[a : a + length] for a in range(0, len(candidates), length)]
