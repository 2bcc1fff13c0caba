"""What a sampler of constant unknowns returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from probreg import arviz_adapter
from probreg.arviz_adapter import Convergence
from probreg.posterior.posterior import Posterior
from probreg.samplers._base import BaseDraws
from probreg.samplers._mixing import unmixed
from probreg.typing import FloatArray

if TYPE_CHECKING:
    import pandas as pd


class Sampler(Protocol):
    """What studies, diagnostics and conformance tests ask of a sampler: settings, one method."""

    def sample(
        self, posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> Draws:
        """Draw from a posterior.

        This is the contract of every sampler; the docstring of a method says what differs and
        what its `stats` and `facts` hold.

        Parameters
        ----------
        posterior : Posterior
            Under a proper law. Chains start about its mode, wider than it is.
        num_draws, num_chains : int
            Draws of each chain after warm-up, and chains.
        rng : numpy.random.Generator
            The same generator gives the same draws; no global state is touched.

        Returns
        -------
        Draws
            Natural values, chain by chain; `stats` has "log_prob" of each draw.

        Raises
        ------
        ImproperLawError
            The noise law has no density.
        InvalidInputError
            Not a posterior or a generator, draws or chains below one, a posterior that the
            sampler is not for, a mode that no chain can start at.
        """


@dataclass(frozen=True, eq=False)
class Draws(BaseDraws):
    """Draws of the constant unknowns of a posterior.

    Attributes
    ----------
    posterior : Posterior
    theta : ndarray, shape (chain, draw, d)
        Natural values: metres, radians, noise parameters.
    sampler, stats, gamma, facts
        As of all draws.
    """

    posterior: Posterior
    theta: FloatArray

    @property
    def _values(self) -> FloatArray:
        return self.flat

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return self.posterior.names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the unknowns."""
        return self.posterior.units

    @property
    def flat(self) -> FloatArray:
        """All draws, shape (chain * draw, d)."""
        return self.theta.reshape(-1, self.theta.shape[-1])

    @property
    def covariance(self) -> FloatArray:
        """Posterior covariance, shape (d, d)."""
        return np.atleast_2d(np.cov(self.flat.T))

    @cached_property
    def convergence(self) -> Convergence:
        """R-hat, effective sample sizes and Monte-Carlo errors."""
        return arviz_adapter.convergence(self.theta)

    def _unmixed(self) -> list[str]:
        enough = self.theta.shape[1] >= arviz_adapter.MIN_DRAWS
        return unmixed(self.theta, self.names, self.convergence if enough else None)

    def _judged(self) -> Mapping[str, FloatArray]:
        return self.convergence._asdict()

    def prior_text(self) -> tuple[str, ...]:
        """Prior of each unknown, as words."""
        posterior, said = self.posterior, []
        for k, name in enumerate(posterior.problem.names):
            prior = posterior.prior
            if prior is None:
                said.append(f"{name}: flat")
            else:
                sd = float(np.sqrt(prior.covariance[k, k]))
                unit = posterior.units[k]
                said.append(f"{name}: normal {prior.mean[k]:.4g} +- {sd:.4g} {unit}".rstrip())
        if posterior.box is not None:
            for name, (low, high) in zip(posterior.problem.names, posterior.box, strict=True):
                if np.isfinite(low) or np.isfinite(high):
                    said.append(f"{name}: cut to {low:.4g} .. {high:.4g}")
        said += [
            f"noise.{p.name}: median {p.median:g}, spread {p.spread:g} (free coordinate)"
            for p in posterior.noise_prior
        ]
        return tuple(said)

    def summary(self, probability: float = 0.9) -> pd.DataFrame:
        """One row an unknown: mean, sd, equal-tailed interval, R-hat, ESS, Monte-Carlo error.

        The table's `attrs` hold the sampler, gamma, the priors and the warnings.
        """
        table = super().summary(probability)
        table.attrs["prior"] = self.prior_text()
        return table

    def to_arviz(self, rng: np.random.Generator | None = None, log_likelihood: bool = True) -> Any:
        """InferenceData (ArviZ before 1.0) or DataTree (later).

        Groups: posterior, sample_stats, observed_data (the whitened rows at the mode of the
        problem's unknowns), log_likelihood by row, and with a generator posterior_predictive
        (replicated whitened residuals about each draw's fit).

        Parameters
        ----------
        rng : numpy.random.Generator, optional
            Draws the posterior predictive.
        log_likelihood : bool
            Leave it out where rows times draws do not fit in memory.
        """
        x = self.posterior.free(self.theta)
        chosen = {name.replace(" ", "_"): self.theta[..., k] for k, name in enumerate(self.names)}
        groups: dict[str, dict[str, FloatArray]] = {
            "posterior": chosen,
            "sample_stats": {("lp" if k == "log_prob" else k): v for k, v in self.stats.items()},
        }
        rows = self.posterior.rows
        origin = self.posterior.laplace.mean[: self.posterior.dim_theta]
        observed = rows.residual(origin)
        dims = {"y": ["row", "component"], "rows": ["row"]}
        groups["observed_data"] = {"y": observed}
        if log_likelihood:
            groups["log_likelihood"] = {"rows": self.posterior.log_likelihood(x)}
        if rng is not None:
            groups["posterior_predictive"] = {"y": self._replicated(rng, x, observed)}
        attrs = {"sampler": self.sampler, "gamma": self.gamma, "created_by": "probreg"}
        if self.gamma != 1.0:
            attrs["warning"] = self.warnings[0]
        return arviz_adapter.inference_data(groups, {}, dims, attrs)

    def _replicated(
        self, rng: np.random.Generator, x: FloatArray, observed: FloatArray
    ) -> FloatArray:
        """Whitened rows as they would be reported again, about the same origin as `observed`."""
        chains, draws, _ = x.shape
        out = np.zeros((chains, draws, *observed.shape))
        sizes = self.posterior.rows.size
        for c in range(chains):
            for k in range(draws):
                theta = x[c, k, : self.posterior.dim_theta]
                shift = observed - self.posterior.rows.residual(theta)
                law = self.posterior.law(x[c, k])
                for m in np.unique(sizes):  # some laws depend on the dimension of a row
                    own = sizes == m
                    out[c, k, own, :m] = shift[own, :m] + law.sample(rng, int(own.sum()), int(m))
        return out

    def _footer(self) -> list[str]:
        return ["prior", *(f"  {text}" for text in self.prior_text())]
