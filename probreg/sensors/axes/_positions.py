"""Positions in the common frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.sensors.axes._axes import Observed
from probreg.sensors.axes._coordinates import Coordinates
from probreg.typing import FloatArray


@dataclass(frozen=True)
class PositionAxes(Coordinates):
    """Positions in the common frame, (x, y) or (x, y, z).

    Parameters
    ----------
    dim : int
        Coordinates of the frame.
    components : int, optional
        How many of them are reported, by default all.

    Raises
    ------
    InvalidInputError
        More components than the frame has.
    """

    dim: int
    components: int | None = None

    def observe(self, x: FloatArray) -> Observed:
        """The positions themselves."""
        n, q = len(x), self._count
        return Observed(x[:, :q], np.tile(np.eye(self.dim)[:q], (n, 1, 1)), np.ones((n, q)))

    def place(self, values: FloatArray, height: FloatArray) -> FloatArray:
        """The reports themselves; without a third coordinate at `height`."""
        if self.dim == 2:
            return values
        up = np.full(len(values), np.nan) if self._count == 2 else values[:, 2]
        up = np.where(np.isnan(up), height, up)
        return np.concatenate([values[:, :2], up[:, None]], axis=1)
