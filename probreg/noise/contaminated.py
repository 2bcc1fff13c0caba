"""The contaminated Gaussian: a share of the rows is noisier by a known factor."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, ClassVar

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise._checks import above_zero
from probreg.noise._law import Size
from probreg.noise._scale_mixture import (
    Mixture,
    MixtureCounts,
    ScaleMixture,
    draw_scale,
    weak_scale,
)
from probreg.noise._support import ABOVE_ONE, POSITIVE, SHARE, Support
from probreg.typing import FloatArray

LEAST_SCALE = 1.5  # of outliers, where it is estimated
RATE_ROWS = 10.0  # that the rate given counts for


@dataclass(frozen=True)
class Contaminated(ScaleMixture):
    """(1 - rate) N(0, I) + rate N(0, scale^2 I).

    Parameters
    ----------
    rate : float or array
        Share of outliers, in (0, 1).
    scale : float or array
        Standard deviation of an outlier over that of a good row, above 1.
    core_scale : float or array
        Factor on the square root of R, common to both components.
    componentwise : bool
        Contaminate every whitened component on its own.
    """

    rate: Any = 0.1
    scale: Any = 10.0
    _: KW_ONLY
    core_scale: Any = 1.0
    componentwise: bool = False

    convex: ClassVar[bool] = False
    unit_name: ClassVar[str] = "core_scale"
    supports: ClassVar[Mapping[str, Support]] = {
        "rate": SHARE,
        "scale": ABOVE_ONE,
        "core_scale": POSITIVE,
    }

    def __post_init__(self) -> None:
        above_zero(self, rate=self.rate, scale=self.scale, core_scale=self.core_scale)
        if np.any(np.asarray(self.rate) >= 1.0) or np.any(np.asarray(self.scale) <= 1.0):
            raise InvalidInputError(
                f"Contaminated: rate {self.rate!r} must lie in (0, 1) and scale {self.scale!r}, "
                "the outliers' standard deviation over the nominal one, above 1."
            )

    @staticmethod
    def weight_function(d2: float, m: float, params: FloatArray) -> float:
        """Posterior mean of the precision."""
        rate, precision = params[0], 1.0 / params[1] ** 2
        # odds of the narrow component: no overflow at large d2, no cancellation at large scales
        odds = (1.0 - rate) / rate * params[1] ** m * np.exp(-0.5 * d2 * (1.0 - precision))
        return 1.0 if odds > 1e300 else (odds + precision) / (odds + 1.0)

    @staticmethod
    def kernel_function(d2: Any, m: Any, params: Any) -> Any:
        """Log of the sum of both components."""
        wide = np.log(params[0]) - m * np.log(params[1]) - 0.5 * d2 / params[1] ** 2
        narrow = np.log1p(-params[0]) - 0.5 * d2
        top = np.maximum(wide, narrow)
        return top + np.log(np.exp(wide - top) + np.exp(narrow - top))

    @property
    def unit(self) -> Any:
        """The common scale; `scale` is the outliers' own."""
        return self.core_scale

    @property
    def params(self) -> tuple[Any, ...]:
        """(rate, scale)."""
        return (self.rate, self.scale)

    @property
    def corners(self) -> tuple[float, ...]:
        """Where the narrow and the wide component end."""
        return (4.0, 8.0 * float(self.scale))

    def parameter_slope(self, name: str, d2: FloatArray, m: Size) -> FloatArray:
        """Derivative by the rate or by the outliers' scale: through the odds of an outlier."""
        rate, scale = np.asarray(self.rate, dtype=float), np.asarray(self.scale, dtype=float)
        wide = (1.0 - self.unit_weight(d2, m)) / (1.0 - 1.0 / scale**2)
        if name == "rate":
            slope: FloatArray = wide / rate - (1.0 - wide) / (1.0 - rate)
        else:
            slope = wide * (d2 / scale**2 - m) / scale
        return slope

    def log_normalizer(self, m: int) -> float:
        """(m / 2) log 2 pi."""
        return 0.5 * m * float(np.log(2.0 * np.pi))

    def unit_covariance_factor(self, m: int) -> Any:
        """1 - rate + rate scale^2."""
        return 1.0 - self.rate + self.rate * self.scale**2

    def outlier_probability(self, v: FloatArray, m: Size | None = None) -> FloatArray:
        """Posterior probability that a row with this whitened residual is an outlier."""
        law = self._spread()
        d2, size = law.squared_norm(v, m)
        return (1.0 - law.unit_weight(d2, size)) / (1.0 - 1.0 / np.asarray(law.scale) ** 2)

    def sample_unit(self, rng: np.random.Generator, n: int, m: int) -> FloatArray:
        """Normal vectors, a share `rate` of them stretched by `scale`."""
        stretch = np.where(rng.random(n) < self.rate, self.scale, 1.0)
        return stretch[:, None] * rng.standard_normal((n, m))

    def draw_unit_precision(self, rng: np.random.Generator, d2: FloatArray, m: Size) -> FloatArray:
        """1 or 1 / scale^2, by the posterior odds."""
        precision = 1.0 / np.asarray(self.scale) ** 2
        wide = (1.0 - self.unit_weight(d2, m)) / (1.0 - precision)
        return np.where(rng.random(np.shape(d2)) < wide, precision, 1.0)

    def unit_mixture(self, m: int) -> Mixture:
        """The good rows and the outliers."""
        rate, scale = float(self.rate), float(self.scale)
        return Mixture(np.array([1.0 - rate, rate]), np.array([1.0, scale**2]))

    def refitted(
        self, counts: MixtureCounts, m: int, unknown: Collection[str], about: Contaminated
    ) -> Contaminated:
        """Rate, scales of good rows and of outliers.

        The rate's prior is a beta law about the given one, of ten rows.
        """
        return self._changed(
            unknown,
            (counts.rows[1] + RATE_ROWS * about.rate) / (counts.rows.sum() + RATE_ROWS),
            weak_scale(counts.square[0], counts.components[0], about.core_scale),
            weak_scale(counts.square[1], counts.components[1], about.core_scale * about.scale),
        )

    def draw_parameters(
        self,
        rng: np.random.Generator,
        counts: MixtureCounts,
        m: int,
        unknown: Collection[str],
        about: Contaminated,
    ) -> Contaminated:
        """Draw rate and scales given which rows are outliers."""
        bad, good = counts.rows[1], counts.rows[0]
        return self._changed(
            unknown,
            rng.beta(bad + RATE_ROWS * about.rate, good + RATE_ROWS * (1.0 - about.rate)),
            draw_scale(rng, counts.square[0], counts.components[0], about.core_scale),
            draw_scale(rng, counts.square[1], counts.components[1], about.core_scale * about.scale),
        )

    def _changed(
        self, unknown: Collection[str], rate: float, core: float, wide: float
    ) -> Contaminated:
        """The law with those of the parameters that are unknown; `wide` is an outlier's scale."""
        unit = float(core if "core_scale" in unknown else self.core_scale)
        out = float(wide if "scale" in unknown else self.core_scale * self.scale)
        share = float(np.clip(rate, 1e-9, 1.0 - 1e-9)) if "rate" in unknown else self.rate
        # outliers closer than this cannot be told from good rows
        far = max(out / unit, LEAST_SCALE) if "scale" in unknown else self.scale
        return replace(self, rate=share, core_scale=unit, scale=far)
