"""What all draws share: names, moments, intervals, warnings, a table, ArviZ and print."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from probreg.numerics.intervals import equal_tailed
from probreg.typing import FloatArray, IntArray

if TYPE_CHECKING:
    import pandas as pd

PARETO_K = 0.7
_SHOWN = 3  # scans that print shows


@dataclass(frozen=True, eq=False, kw_only=True)
class BaseDraws(ABC):
    """Draws of named unknowns, with what is needed to judge them.

    A subclass holds the draws: of constants (`Draws`), of whole paths (`PathDraws`), of states
    scan by scan (`Track`). Moments have the shape of one draw: (d,), or (T, d) over T scans.

    Attributes
    ----------
    sampler : str
    stats : mapping of str to ndarray, shape (chain, draw)
        Of each draw: "log_prob", "accepted", "diverging", ...
    gamma : float
        Sharpening exponent; other than 1 the draws are not from the posterior.
    facts : mapping
        Of the run: acceptance, step sizes, Pareto k, what the sampler's docstring says.
    """

    sampler: str
    stats: Mapping[str, FloatArray] = field(default_factory=dict)
    gamma: float = 1.0
    facts: Mapping[str, Any] = field(default_factory=dict)

    _over: ClassVar[tuple[int, ...]] = (0,)  # axes of the values that run over draws

    # -- what the draws are of -----------------------------------------------------------

    @property
    @abstractmethod
    def _values(self) -> FloatArray:
        """All draws, the last axis the d unknowns."""

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Names of the d unknowns."""

    @property
    @abstractmethod
    def units(self) -> tuple[str, ...]:
        """Units of the d unknowns."""

    @property
    def scans(self) -> tuple[str, ...]:
        """Where in time the scans are, as words; none where the unknowns are constant."""
        return ()

    # -- moments -------------------------------------------------------------------------

    @property
    def mean(self) -> FloatArray:
        """Posterior means."""
        return self._values.mean(axis=self._over)

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations."""
        return self._values.std(axis=self._over, ddof=1)

    def interval(self, probability: float) -> FloatArray:
        """Equal-tailed credible intervals: lower and upper ends along a last axis."""
        return equal_tailed(self._values, probability, self._over)

    # -- how far to trust them -----------------------------------------------------------

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What a reader must know before using these draws; empty if nothing."""
        said = []
        if self.gamma != 1.0:
            said.append(
                f"gamma = {self.gamma:g}: the target is the posterior to that power, not the "
                "posterior. Intervals are too narrow (gamma > 1) or too wide."
            )
        said += self._unmixed()
        diverging = int(np.sum(self.stats.get("diverging", 0)))
        if diverging:
            said.append(f"{diverging} divergent transitions: the geometry defeats the step size.")
        k = self.facts.get("pareto_k")
        if k is not None and not k <= PARETO_K:
            said.append(f"Pareto k is {k:.2f}: importance weights are not to be trusted.")
        return tuple(said)

    @abstractmethod
    def _unmixed(self) -> list[str]:
        """What says that there are too few good draws; empty if nothing."""

    @abstractmethod
    def _judged(self) -> Mapping[str, FloatArray]:
        """Columns of the table that judge each unknown (at each scan)."""

    # -- what is shown -------------------------------------------------------------------

    def summary(self, probability: float = 0.9) -> pd.DataFrame:
        """One row an unknown (at each scan): mean, sd, equal-tailed interval, how good, unit.

        The table's `attrs` hold the sampler, gamma and the warnings.
        """
        import pandas as pd

        index: Any = list(self.names)
        if self.scans:
            index = pd.MultiIndex.from_product([self.scans, index], names=["scan", "unknown"])
        interval = self.interval(probability).reshape(-1, 2)
        percent = 100.0 * np.array([0.5 - 0.5 * probability, 0.5 + 0.5 * probability])
        table = pd.DataFrame(
            {
                "mean": self.mean.ravel(),
                "sd": self.sd.ravel(),
                f"{percent[0]:g}%": interval[:, 0],
                f"{percent[1]:g}%": interval[:, 1],
                **self._judged(),
                "unit": self.units * max(1, len(self.scans)),
            },
            index=index,
        )
        if self.gamma != 1.0:
            table.insert(0, "not a posterior", f"gamma = {self.gamma:g}")
        table.attrs.update(sampler=self.sampler, gamma=self.gamma, warnings=self.warnings)
        return table

    @abstractmethod
    def to_arviz(self) -> Any:
        """InferenceData (ArviZ before 1.0) or DataTree (later)."""

    def __str__(self) -> str:
        """A table with angles in milliradians, the warnings first; of many scans, a few."""
        mean, sd, interval = self.mean, self.sd, self.interval(0.9)
        d = len(self.names)
        # scans by unknowns, one scan where the unknowns are constant
        mean, sd = self.mean.reshape(-1, d), self.sd.reshape(-1, d)
        interval = self.interval(0.9).reshape(-1, d, 2)
        lines = [f"warning: {text}" for text in self.warnings]
        for t in spread_out(len(mean), _SHOWN):
            when = f" at {self.scans[t]}" if self.scans else ""
            for k, (name, unit) in enumerate(zip(self.names, self.units, strict=True)):
                label = f"{name}{when}"
                lines.append(shown(label, unit, mean[t, k], sd[t, k], interval[t, k]))
        return "\n".join([*lines, *self._footer()])

    def _footer(self) -> list[str]:
        """Lines that print adds."""
        return []


def shown(label: str, unit: str, mean: float, sd: float, interval: FloatArray) -> str:
    """One line of a print; radians become milliradians."""
    factor, unit = (1e3, "mrad") if unit == "rad" else (1.0, unit)
    low, high = factor * interval
    text = f"{label:<20} {factor * mean:12.4f} +- {factor * sd:<10.4f} {unit:<5}"
    return f"{text} 90 %: {low:.4f} to {high:.4f}"


def spread_out(count: int, most: int) -> IntArray:
    """At most so many numbers below `count`, evenly apart, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def scan_labels(time: FloatArray | None, count: int) -> tuple[str, ...]:
    """Scans as words: by their times (T,) in seconds, or by their numbers."""
    if time is None:
        return tuple(f"scan {t}" for t in range(count))
    return tuple(f"{t:.10g} s" for t in time)
