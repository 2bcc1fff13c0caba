"""Draws of biases that drift, over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.sensors.drifts import Drift
from probreg.typing import FloatArray


@dataclass(frozen=True, eq=False)
class BiasPathDraws:
    """Whole paths of the biases that drift, at knots with lines between them.

    Attributes
    ----------
    number : tuple of int
        Of each drifting bias, among all.
    kinds : tuple of Drift
    time : ndarray, shape (T,)
        Of the knots: stamps of reports.
    values : ndarray, shape (chain, draw, T, d)
        SI units.
    spread : ndarray, shape (chain, draw, d)
        Zero in draws without drift.
    constant : ndarray, shape (d,)
        Probability that the bias does not drift.
    """

    number: tuple[int, ...]
    kinds: tuple[Drift, ...]
    time: FloatArray
    values: FloatArray
    spread: FloatArray
    constant: FloatArray

    @property
    def flat(self) -> FloatArray:
        """All paths, shape (chain * draw, T, d)."""
        return self.values.reshape(-1, *self.values.shape[2:])

    def at(self, stamp: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Paths (chain * draw, n, d) at stamps (n,), with what they may do between two knots.

        Each stamp by itself: a bridge from knot to knot is drawn anew at each. Beyond the first
        and last knot paths are held.
        """
        time, paths = self.time, self.flat
        left = np.clip(np.searchsorted(time, stamp, side="right") - 1, 0, len(time) - 2)
        interval = time[left + 1] - time[left]
        share = np.clip((stamp - time[left]) / interval, 0.0, 1.0)
        spread = self.spread.reshape(-1, 1, len(self.kinds))
        out = np.empty((len(paths), len(stamp), len(self.kinds)))
        for j, kind in enumerate(self.kinds):
            ends = paths[:, left, j], paths[:, left + 1, j]
            size = spread[..., j] * np.sqrt(kind.step_variance(interval))
            out[..., j] = kind.between(ends, share, size, rng)
        return out
