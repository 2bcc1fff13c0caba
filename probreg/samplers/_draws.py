"""What a sampler returns, and what it says of itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from probreg import arviz_adapter
from probreg.arviz_adapter import Convergence
from probreg.numerics.intervals import equal_tailed
from probreg.posterior.posterior import Posterior
from probreg.typing import FloatArray

if TYPE_CHECKING:
    import pandas as pd

R_HAT = 1.01
FEW = 400  # effective draws below which quantiles are rough (Vehtari et al. 2021)
PARETO_K = 0.7


class Sampler(Protocol):
    """What studies, diagnostics and conformance tests ask of a sampler."""

    def sample(
        self, posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> Draws:
        """Draw from a posterior."""


@dataclass(frozen=True, eq=False)
class Draws:
    """Draws of the unknowns, with what is needed to judge them.

    Attributes
    ----------
    posterior : Posterior
    theta : ndarray, shape (chain, draw, d)
        Natural values: metres, radians, noise parameters.
    stats : mapping of str to ndarray, shape (chain, draw)
        Of each draw: "log_prob", "accepted", "diverging", ...
    sampler : str
    gamma : float
        Sharpening exponent; other than 1 the draws are not from the posterior.
    facts : mapping
        Of the run: acceptance, step sizes, Pareto k, what the sampler's docstring says.
    """

    posterior: Posterior
    theta: FloatArray
    stats: Mapping[str, FloatArray]
    sampler: str
    gamma: float = 1.0
    facts: Mapping[str, Any] = field(default_factory=dict)

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
    def mean(self) -> FloatArray:
        """Posterior means, shape (d,)."""
        return self.flat.mean(axis=0)

    @property
    def covariance(self) -> FloatArray:
        """Posterior covariance, shape (d, d)."""
        return np.atleast_2d(np.cov(self.flat.T))

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations, shape (d,)."""
        return self.flat.std(axis=0, ddof=1)

    def interval(self, probability: float) -> FloatArray:
        """Equal-tailed credible intervals, shape (d, 2)."""
        return equal_tailed(self.flat, probability, (0,))

    @cached_property
    def convergence(self) -> Convergence:
        """R-hat, effective sample sizes and Monte-Carlo errors."""
        return arviz_adapter.convergence(self.theta)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What a reader must know before using these draws; empty if nothing."""
        said = []
        if self.gamma != 1.0:
            said.append(
                f"gamma = {self.gamma:g}: the target is the posterior to that power, not the "
                "posterior. Intervals are too narrow (gamma > 1) or too wide."
            )
        if self.theta.shape[1] < arviz_adapter.MIN_DRAWS:
            return (*said, "too few draws a chain to judge convergence.")
        found = self.convergence
        # constant draws have neither
        worst = float(np.nanmax(np.append(found.r_hat, 1.0)))
        if not worst <= R_HAT:
            name = self.names[int(np.nanargmax(found.r_hat))]
            said.append(f"R-hat is {worst:.3f} for {name}: the chains have not mixed; run longer.")
        least = float(np.min(np.nan_to_num(np.minimum(found.ess_bulk, found.ess_tail))))
        if least < FEW:
            said.append(f"only {least:.0f} effective draws (bulk or tail); run longer.")
        diverging = int(np.sum(self.stats.get("diverging", 0)))
        if diverging:
            said.append(f"{diverging} divergent transitions: the geometry defeats the step size.")
        k = self.facts.get("pareto_k")
        if k is not None and not k <= PARETO_K:
            said.append(f"Pareto k is {k:.2f}: importance weights are not to be trusted.")
        return tuple(said)

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
        import pandas as pd

        found, interval = self.convergence, self.interval(probability)
        percent = 100.0 * np.array([0.5 - 0.5 * probability, 0.5 + 0.5 * probability])
        table = pd.DataFrame(
            {
                "mean": self.mean,
                "sd": self.sd,
                f"{percent[0]:g}%": interval[:, 0],
                f"{percent[1]:g}%": interval[:, 1],
                "r_hat": found.r_hat,
                "ess_bulk": found.ess_bulk,
                "ess_tail": found.ess_tail,
                "mcse_mean": found.mcse_mean,
                "unit": self.units,
            },
            index=list(self.names),
        )
        if self.gamma != 1.0:
            table.insert(0, "not a posterior", f"gamma = {self.gamma:g}")
        table.attrs.update(
            sampler=self.sampler, gamma=self.gamma, prior=self.prior_text(), warnings=self.warnings
        )
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

    def __str__(self) -> str:
        """A table with angles in milliradians, the priors, and the warnings first."""
        interval = self.interval(0.9)
        lines = [f"warning: {text}" for text in self.warnings]
        for k, (name, unit) in enumerate(zip(self.names, self.units, strict=True)):
            factor, shown = (1e3, "mrad") if unit == "rad" else (1.0, unit)
            low, high = factor * interval[k]
            mean, sd = factor * self.mean[k], factor * self.sd[k]
            text = f"{name:<20} {mean:12.4f} +- {sd:<10.4f} {shown:<5}"
            lines.append(f"{text} 90 %: {low:.4f} to {high:.4f}")
        return "\n".join([*lines, "prior", *(f"  {text}" for text in self.prior_text())])
