"""What a tracker returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from probreg import arviz_adapter
from probreg.motion.trajectory import Trajectory
from probreg.samplers._base import BaseDraws, scan_labels, spread_out
from probreg.typing import FloatArray, IntArray

_FEW = 50  # effective draws of a scan below which its interval is rough
_ENOUGH = 0.9  # of the scans must have as many
_LOOKED_AT = 100  # scans whose chains are judged


class Tracker(Protocol):
    """What studies ask of a method that goes scan by scan: settings and one method."""

    def track(self, model: Trajectory, rng: np.random.Generator) -> Track:
        """Follow the states through all scans; what is said of one rests on those up to it.

        This is the contract of every tracker; the docstring of a method says what differs and
        what its `facts` hold.

        Parameters
        ----------
        model : Trajectory
        rng : numpy.random.Generator
            The same generator gives the same track.

        Returns
        -------
        Track

        Raises
        ------
        InvalidInputError
            Not a trajectory or a generator, or a scan that the method cannot follow.
        """


@dataclass(frozen=True, eq=False)
class Track(BaseDraws):
    """States followed scan by scan.

    Attributes
    ----------
    model : Trajectory
    estimate : ndarray, shape (T, d)
        After each scan: the mean, or what the tracker takes for it.
    draws : ndarray, shape (T, n, d)
        Of each scan by itself: the n-th draws of two scans are no path.
    sampler, gamma, facts
        As of all draws. The facts of a chain hold "acceptance" (T,), those of a particle filter
        "effective" (T,), its effective particles.
    """

    model: Trajectory
    estimate: FloatArray
    draws: FloatArray

    _over: ClassVar[tuple[int, ...]] = (1,)

    @property
    def _values(self) -> FloatArray:
        return self.draws

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the d states."""
        return self.model.names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the d states."""
        return self.model.units

    @property
    def scans(self) -> tuple[str, ...]:
        """Where in time the T scans are, as words."""
        return scan_labels(self.model.time, len(self.draws))

    @property
    def mean(self) -> FloatArray:
        """The estimate after each scan, shape (T, d)."""
        return self.estimate

    def effective(self, scans: IntArray | None = None) -> FloatArray:
        """Effective draws of some scans (or all), the least over the states of a chain, (k,)."""
        at = np.arange(len(self.draws)) if scans is None else scans
        if "effective" in self.facts:
            return np.asarray(self.facts["effective"])[at]
        return np.array([min(_effective(x) for x in self.draws[t].T) for t in at])

    def _unmixed(self) -> list[str]:
        said = []
        edge = int(self.facts.get("at_edge", 0))
        if edge:
            said.append(f"in {edge} scans the walk came to the edge of the box: widen it.")
        if self.draws.shape[1] < arviz_adapter.MIN_DRAWS:
            return [*said, "too few draws a scan to judge them."]
        at = spread_out(len(self.draws), _LOOKED_AT)
        found = self.effective(at)
        # particles of equal weight are exact, however few they are
        few = (found < _FEW) & (found < 0.99 * self.facts.get("particles", np.inf))
        if few.mean() > 1.0 - _ENOUGH:
            k = int(np.argmin(found))
            said.append(
                f"{few.sum()} of {len(at)} scans have fewer than {_FEW} effective draws (least "
                f"{found[k]:.0f} at {self.scans[at[k]]}){self._accepted()}: their intervals are "
                "rough; take more steps or particles."
            )
        return said

    def _accepted(self) -> str:
        if "acceptance" not in self.facts:
            return ""
        return f", {100.0 * np.median(self.facts['acceptance']):.2g} % of proposals accepted"

    def _judged(self) -> Mapping[str, FloatArray]:
        """Effective draws, and of a chain the acceptance, the same for all states of a scan."""
        columns = {"effective": self.effective()}
        if "acceptance" in self.facts:
            columns["acceptance"] = self.facts["acceptance"]
        return {name: np.repeat(value, len(self.names)) for name, value in columns.items()}

    def to_arviz(self) -> Any:
        """InferenceData (ArviZ before 1.0) or DataTree: "state" by time and state, one chain.

        Each scan's draws are its own: across scans they are no path.
        """
        coords: dict[str, Any] = {"state": list(self.names)}
        if self.model.time is not None:
            coords["time"] = list(self.model.time)
        groups = {"posterior": {"track": np.swapaxes(self.draws, 0, 1)[None]}}
        attrs = {"sampler": self.sampler, "gamma": self.gamma}
        if self.gamma != 1.0:
            attrs["warning"] = self.warnings[0]
        return arviz_adapter.inference_data(groups, coords, {"track": ["time", "state"]}, attrs)


def _effective(series: FloatArray) -> float:
    """Effective draws of a chain (n,) of one state; one that never moved has none."""
    return 0.0 if np.ptp(series) == 0.0 else arviz_adapter.ess(series[None])
