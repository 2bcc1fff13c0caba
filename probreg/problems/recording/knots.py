"""Coefficients of biases that drift: values at knots in time, with lines between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import FloatArray, IntArray
from probreg.validation import finite_array

Part = tuple[IntArray | int, FloatArray | float]


@dataclass(frozen=True, eq=False)
class Knots:
    """Where the coefficients of p biases stand in one vector of P.

    Constant ones come first, then those of all drifting biases knot by knot, so that what
    reports say of them has a narrow band. A drifting coefficient is linear between knots and
    constant beyond them, by the stamps of the reports: those do not move when clocks are fitted.

    Parameters
    ----------
    num_biases : int
        p.
    drifting : tuple of int
        Which of them drift.
    time : ndarray, shape (T,)
        Of the knots, increasing; empty if nothing drifts.

    Raises
    ------
    InvalidInputError
        Fewer than two knots for something that drifts, times that do not increase.
    """

    num_biases: int
    drifting: tuple[int, ...] = ()
    time: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        time = finite_array("time of knots", self.time, (None,))
        if (np.diff(time) <= 0.0).any() or (self.drifting and len(time) < 2):
            raise InvalidInputError("knots must be two or more, at times that increase.")
        object.__setattr__(self, "time", time)

    @property
    def num_static(self) -> int:
        """Constant coefficients."""
        return self.num_biases - len(self.drifting)

    @property
    def size(self) -> int:
        """P."""
        return self.num_static + len(self.time) * len(self.drifting)

    @cached_property
    def static(self) -> IntArray:
        """Biases that are constant, in their order among the coefficients."""
        return np.setdiff1d(np.arange(self.num_biases), self.drifting)

    def places(self, bias: int) -> IntArray:
        """Where the coefficients of a bias stand: one, or one a knot."""
        if bias not in self.drifting:
            return np.flatnonzero(self.static == bias)
        d = len(self.drifting)
        return self.num_static + self.drifting.index(bias) + d * np.arange(len(self.time))

    def between(self, stamp: FloatArray) -> tuple[IntArray, FloatArray]:
        """The knot before each stamp, and the share (0 to 1) of the next one."""
        left = np.clip(np.searchsorted(self.time, stamp, side="right") - 1, 0, len(self.time) - 2)
        share = (stamp - self.time[left]) / (self.time[left + 1] - self.time[left])
        return left, np.clip(share, 0.0, 1.0)

    def parts(self, bias: int, stamp: FloatArray) -> tuple[Part, ...]:
        """Coefficients that make up that of a bias at each stamp, with their shares."""
        place = self.places(bias)
        if bias not in self.drifting:
            return ((int(place[0]), 1.0),)
        left, share = self.between(stamp)
        return ((place[left], 1.0 - share), (place[left + 1], share))

    def value(self, theta: FloatArray, bias: int, stamp: FloatArray) -> FloatArray | float:
        """Coefficient of a bias at each stamp."""
        return sum(theta[place] * share for place, share in self.parts(bias, stamp))

    def widths(self, bias: int) -> int:
        """How many coefficients a report has part in through a bias."""
        return 2 if bias in self.drifting else 1

    @cached_property
    def constant(self) -> FloatArray:
        """Matrix (P, p) from biases that stay as they are to all coefficients."""
        out = np.zeros((self.size, self.num_biases))
        for bias in range(self.num_biases):
            out[self.places(bias), bias] = 1.0
        return out

    def spread(self, biases: FloatArray) -> FloatArray:
        """Coefficients (P,) of biases (p,) that stay as they are."""
        return biases if not self.drifting else np.asarray(self.constant @ biases)

    def averages(self, theta: FloatArray) -> FloatArray:
        """Averages (..., p) of coefficients (..., P) over the time of the knots."""
        return theta if not self.drifting else np.asarray(theta @ self.average.T)

    def averaged(self, covariance: FloatArray) -> FloatArray:
        """Covariance (p, p) of the averages from that of the coefficients (P, P)."""
        return covariance if not self.drifting else self.average @ covariance @ self.average.T

    @cached_property
    def average(self) -> FloatArray:
        """Matrix (p, P) from coefficients to averages over the time of the knots."""
        out = np.zeros((self.num_biases, self.size))
        step = np.diff(self.time)
        share = np.convolve(step, [0.5, 0.5]) / step.sum() if len(step) else step
        for bias in range(self.num_biases):
            out[bias, self.places(bias)] = share if bias in self.drifting else 1.0
        return out

    def at(self, theta: FloatArray, stamp: FloatArray) -> FloatArray:
        """Coefficients (..., n, p) of all biases at stamps (n,) for theta (..., P)."""
        out = np.empty((*theta.shape[:-1], len(stamp), self.num_biases))
        for bias in range(self.num_biases):
            own = theta[..., self.places(bias)]
            if bias in self.drifting:
                left, share = self.between(stamp)
                own = own[..., left] * (1.0 - share) + own[..., left + 1] * share
            out[..., bias] = own
        return out

    def with_more(self, count: int) -> tuple[Knots, IntArray]:
        """With constant biases added at the end, and where the old coefficients then stand."""
        more = Knots(self.num_biases + count, self.drifting, self.time)
        place = np.arange(self.size)
        return more, np.where(place < self.num_static, place, place + count)
