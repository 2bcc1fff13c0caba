"""Positions in the common frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.sensors.axes._axes import Observed
from probreg.typing import BoolArray, FloatArray


@dataclass(frozen=True)
class PositionAxes:
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

    def __post_init__(self) -> None:
        if self._count > self.dim:
            raise InvalidInputError(f"{self._count} coordinates reported in {self.dim} dimensions.")

    @property
    def _count(self) -> int:
        return self.dim if self.components is None else self.components

    @property
    def angles(self) -> BoolArray:
        """None."""
        return np.zeros(self._count, dtype=bool)

    @property
    def vertical(self) -> BoolArray:
        """The third."""
        return np.arange(self._count) == 2

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
