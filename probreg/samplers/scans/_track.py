"""What a tracker returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from probreg.numerics.intervals import equal_tailed
from probreg.typing import FloatArray


@dataclass(frozen=True, eq=False)
class Track:
    """A bias followed scan by scan.

    Attributes
    ----------
    names : tuple of str
    mean : ndarray, shape (T, d)
        The estimate after each scan.
    draws : ndarray, shape (T, n, d)
        Of each scan.
    gamma : float
        Sharpening exponent; other than 1 the draws are not from the posterior.
    facts : mapping
        Of the run.
    """

    names: tuple[str, ...]
    mean: FloatArray
    draws: FloatArray
    gamma: float
    facts: Mapping[str, Any]

    def interval(self, probability: float) -> FloatArray:
        """Equal-tailed intervals of the draws of each scan, shape (T, d, 2)."""
        return equal_tailed(self.draws, probability, (1,))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader must know before using the track; empty if nothing."""
        said = []
        if self.gamma != 1.0:
            said.append(
                f"gamma = {self.gamma:g}: the draws are not from the posterior and their "
                "intervals are wrong."
            )
        edge = int(self.facts.get("at_edge", 0))
        if edge:
            said.append(f"in {edge} scans the walk came to the edge of the box: widen it.")
        return tuple(said)
