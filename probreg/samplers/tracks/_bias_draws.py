"""Draws of the biases of a recording's sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from probreg import arviz_adapter
from probreg.arviz_adapter import Convergence
from probreg.samplers._base import BaseDraws
from probreg.samplers._mixing import unmixed
from probreg.samplers.tracks._path_draws import BiasPathDraws
from probreg.typing import FloatArray


@dataclass(frozen=True, eq=False)
class BiasDraws(BaseDraws):
    """Draws of biases; `sampler` says how they came about, `facts["independent"]` if at once.

    Attributes
    ----------
    theta : ndarray, shape (chain, draw, p)
    labels, symbols : tuple of str
        Names of the biases and their units, SI.
    paths : BiasPathDraws, optional
        Of biases that drift, whole paths of the same draws; `theta` then has their averages.
    """

    theta: FloatArray
    labels: tuple[str, ...]
    symbols: tuple[str, ...]
    paths: BiasPathDraws | None = None

    @property
    def _values(self) -> FloatArray:
        return self.flat

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the biases."""
        return self.labels

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the biases."""
        return self.symbols

    @property
    def flat(self) -> FloatArray:
        """All draws, shape (chain * draw, p)."""
        return self.theta.reshape(-1, self.theta.shape[-1])

    @cached_property
    def convergence(self) -> Convergence:
        """R-hat, effective sample sizes and Monte-Carlo errors."""
        return arviz_adapter.convergence(self.theta)

    def _unmixed(self) -> list[str]:
        if self.facts.get("independent"):
            return []
        return unmixed(self.theta, self.names, self.convergence)

    def _judged(self) -> Mapping[str, FloatArray]:
        return self.convergence._asdict()

    def to_arviz(self) -> Any:
        """InferenceData (ArviZ before 1.0) or DataTree (later) of the posterior."""
        chosen = {name.replace(" ", "_"): self.theta[..., k] for k, name in enumerate(self.names)}
        dims: dict[str, list[str]] = {}
        if self.paths is not None:
            for j, k in enumerate(self.paths.number):
                name = self.names[k].replace(" ", "_")
                chosen[f"{name}.path"] = self.paths.values[..., j]
                chosen[f"{name}.spread"] = self.paths.spread[..., j]
                dims[f"{name}.path"] = ["time"]
        attrs = {"sampler": self.sampler, "gamma": self.gamma, **self.facts}
        attrs = {k: v for k, v in attrs.items() if isinstance(v, str | int | float)}
        coordinates = {} if self.paths is None else {"time": self.paths.time}
        return arviz_adapter.inference_data({"posterior": chosen}, coordinates, dims, attrs)


def normal_draws(
    mean: FloatArray, covariance: FloatArray, shape: tuple[int, int], rng: np.random.Generator
) -> FloatArray:
    """Independent draws (chains, draws, p) of a normal law."""
    root = np.linalg.cholesky(covariance)
    return np.asarray(mean + rng.standard_normal((*shape, len(mean))) @ root.T)
