"""What a path sampler returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np

from probreg import arviz_adapter
from probreg.arviz_adapter import Convergence
from probreg.errors import InvalidInputError
from probreg.posterior.path_posterior import PathPosterior
from probreg.samplers._base import BaseDraws, scan_labels, shown, spread_out
from probreg.samplers._mixing import unmixed_among_many
from probreg.typing import FloatArray
from probreg.validation import sampling_run

_LOOKED_AT = 300  # states at scans whose mixing is judged: each costs milliseconds


class PathSampler(Protocol):
    """What studies and conformance tests ask of a sampler of paths: settings, one method."""

    def sample(
        self, posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> PathDraws:
        """Draw whole paths.

        This is the contract of every sampler of paths; the docstring of a method says what
        differs and what its `stats` and `facts` hold.

        Parameters
        ----------
        posterior : PathPosterior
        num_draws, num_chains : int
            Draws of each chain after warm-up, and chains.
        rng : numpy.random.Generator
            The same generator gives the same paths; no global state is touched.

        Returns
        -------
        PathDraws

        Raises
        ------
        InvalidInputError
            Not a path posterior or a generator, draws or chains below one, a noise law that the
            sampler is not for.
        """


@dataclass(frozen=True, eq=False)
class PathDraws(BaseDraws):
    """Draws of whole paths.

    Attributes
    ----------
    posterior : PathPosterior
    path : ndarray, shape (chain, draw, T, d)
    step_scale : ndarray, shape (chain, draw, k), optional
        Factors on the process noise that were sampled too.
    sampler, stats, gamma, facts
        As of all draws.
    """

    posterior: PathPosterior
    path: FloatArray
    step_scale: FloatArray | None = None

    _over: ClassVar[tuple[int, ...]] = (0, 1)

    @property
    def _values(self) -> FloatArray:
        return self.path

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the d states."""
        return self.posterior.names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the d states."""
        return self.posterior.trajectory.units

    @property
    def scans(self) -> tuple[str, ...]:
        """Where in time the T scans are, as words."""
        return scan_labels(self.posterior.trajectory.time, self.path.shape[2])

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations, shape (T, d), over the number of draws."""
        return self.path.std(axis=self._over)

    @cached_property
    def convergence(self) -> Convergence:
        """R-hat, effective sample sizes, Monte-Carlo errors of every scan and state, (T * d,)."""
        chains, draws = self.path.shape[:2]
        return arviz_adapter.convergence(self.path.reshape(chains, draws, -1))

    def _unmixed(self) -> list[str]:
        """Of long paths some scans are looked at, evenly apart; the factors always are."""
        at = spread_out(len(self.scans), max(2, _LOOKED_AT // len(self.names)))
        labels = [f"{name} at {self.scans[t]}" for t in at for name in self.names]
        values = self.path[:, :, at].reshape(*self.path.shape[:2], -1)
        if self.step_scale is not None:
            values = np.concatenate([values, self.step_scale], axis=2)
            labels += self._factors
        return unmixed_among_many(values, labels)

    def _judged(self) -> Mapping[str, FloatArray]:
        return self.convergence._asdict()

    @property
    def _factors(self) -> list[str]:
        """Names of the factors on the process noise."""
        return [] if self.step_scale is None else [
            f"step_scale[{k}]" for k in range(self.step_scale.shape[2])
        ]  # fmt: skip

    def to_arviz(self) -> Any:
        """InferenceData (ArviZ before 1.0) or DataTree: "path" by time and state."""
        time = self.posterior.trajectory.time
        coords = {"state": list(self.posterior.names)}
        if time is not None:
            coords["time"] = list(time)
        groups = {"posterior": {"path": self.path}}
        if self.step_scale is not None and self.step_scale.shape[-1]:
            groups["posterior"]["step_scale"] = self.step_scale
        if self.stats:
            groups["sample_stats"] = dict(self.stats)
        return arviz_adapter.inference_data(
            groups, coords, {"path": ["time", "state"]}, {"sampler": self.sampler}
        )

    def _footer(self) -> list[str]:
        lines = []
        for k, name in enumerate(self._factors):
            assert self.step_scale is not None
            x = self.step_scale[..., k]
            lines.append(shown(name, "", x.mean(), x.std(ddof=1), np.quantile(x, [0.05, 0.95])))
        return lines


def require_paths(
    posterior: PathPosterior, num_draws: int, num_chains: int, rng: np.random.Generator
) -> None:
    """Raise unless the numbers make sense."""
    if not isinstance(posterior, PathPosterior):
        raise InvalidInputError(f"takes a PathPosterior, not a {type(posterior).__name__}.")
    sampling_run(num_draws, num_chains, rng)
