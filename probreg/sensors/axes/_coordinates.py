"""What axes of positions share."""

from __future__ import annotations

import numpy as np

from probreg.errors import InvalidInputError
from probreg.typing import BoolArray


class Coordinates:
    """Two or three coordinates, the third up; fields live in the subclasses."""

    dim: int
    components: int | None

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
