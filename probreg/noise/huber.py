"""Huber's law: Gaussian in the middle, exponential in the tails."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
from scipy.special import gammainc, gammaincc, gammaln

from probreg.noise._checks import above_zero
from probreg.noise._law import NoiseLaw
from probreg.noise._radial import on_sphere, truncated_chi, truncated_gamma
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Huber(NoiseLaw):
    """Weight 1 up to k, k / d beyond.

    Component-wise it is the weight of Guo et al. (2017), equation (36).

    Parameters
    ----------
    k : float
        Threshold in standard deviations.
    componentwise : bool
        Weigh every whitened component on its own instead of the whole vector. The answer
        then depends on the coordinates, here those of the symmetric root of R.
    scale : float or array
        Factor on the square root of R.
    """

    k: Any = 1.345
    componentwise: bool = False
    _: KW_ONLY
    scale: Any = 1.0

    def __post_init__(self) -> None:
        above_zero(self, k=self.k, scale=self.scale)

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """1 up to k, k / d beyond."""
        d = np.sqrt(d2)
        return 1.0 if d <= params[0] else params[0] / d

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """A parabola up to k, its tangent beyond."""
        d = np.sqrt(d2)
        inner = np.minimum(d, params[0])
        return -0.5 * inner**2 - params[0] * (d - inner)

    @property
    def params(self) -> tuple[Any, ...]:
        """(k,)."""
        return (self.k,)

    @property
    def corners(self) -> tuple[float, ...]:
        """The threshold."""
        return (float(self.k), 10.0 + float(self.k))

    def _log_masses(self, m: int) -> tuple[Any, Any]:
        k = np.asarray(self.k, dtype=float)
        inner = 0.5 * m * np.log(2.0 * np.pi) + np.log(gammainc(0.5 * m, 0.5 * k**2))
        sphere = np.log(2.0) + 0.5 * m * np.log(np.pi) - gammaln(0.5 * m)
        with np.errstate(divide="ignore"):  # no mass beyond a threshold of 30 and more
            tail = np.log(gammaincc(m, k**2))
        return inner, sphere + 0.5 * k**2 + gammaln(m) + tail - m * np.log(k)

    def log_normalizer(self, m: int) -> Any:
        """Incomplete gamma functions of both pieces."""
        return np.logaddexp(*self._log_masses(m))

    def sample_unit(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """Radius from the piece it falls in, direction uniform."""
        inner, outer = self._log_masses(m)
        inside = rng.random(n) < np.exp(inner - np.logaddexp(inner, outer))
        radius = np.empty(n)
        radius[inside] = truncated_chi(rng, int(inside.sum()), m, self.k)
        radius[~inside] = truncated_gamma(rng, int((~inside).sum()), m, self.k**2) / self.k
        return on_sphere(rng, radius, m)
