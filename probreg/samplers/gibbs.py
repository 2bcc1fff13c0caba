"""Gibbs sampling for Gaussian scale mixtures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import ScaleMixture
from probreg.posterior.posterior import Posterior
from probreg.problems.linear import Whitened
from probreg.samplers._draws import Draws
from probreg.samplers._start import require_target, start_states
from probreg.typing import BoolArray, FloatArray

TARGET = 0.35  # acceptance of the random walk in the noise parameters


class _State(NamedTuple):
    """Of all chains: free coordinates (k, d), their log-posterior (k,)."""

    x: FloatArray
    log_prob: FloatArray


@dataclass(frozen=True)
class Gibbs:
    """Gibbs sampling: draw the rows' hidden precisions, then the unknowns, which are Gaussian.

    For Student-t, contaminated, hyperbolic (without the piecewise bound) and Gaussian noise.
    Unknown noise parameters take a random-walk step with the precisions integrated out,
    tuned in warm-up only. Where the problem is not linear (bearings) or cut by a box, the
    Gaussian draw is a proposal that is accepted or rejected.

    Parameters
    ----------
    warmup : int
        Sweeps before the first draw.
    walks : int
        Steps in the noise parameters a sweep.
    """

    warmup: int = 50
    walks: int = 3

    def __post_init__(self) -> None:
        if self.warmup < 0 or self.walks < 1:
            raise InvalidInputError("warmup must be zero or more and walks one or more.")

    def sample(
        self, posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> Draws:
        """Draw in turn.

        `stats` has "accepted" too; `facts` the warm-up and, of the walk in the noise parameters,
        its acceptance rate and tuned step.

        Raises
        ------
        InvalidInputError
            Also where the law is no Gaussian scale mixture.
        """
        require_target(posterior, num_draws, num_chains, rng)
        noise = posterior.noise
        if not noise.scale_mixture:
            raise InvalidInputError(
                f"{noise!r} is not a Gaussian given a hidden precision, so there is no Gibbs "
                "step. Take MetropolisHastings or Nuts."
            )
        sweep = _Sweep(posterior)
        state = _State(*start_states(posterior, num_chains, rng))
        step, rates = 1.0, []
        for k in range(self.warmup):
            state, rate = self._walk(posterior, state, step, rng)
            step *= float(np.exp(2.0 * (k + 1.0) ** -0.6 * (rate - TARGET)))
            state, _ = sweep.draw(state, rng)
        kept = np.empty((num_draws, num_chains, posterior.dim))
        height: FloatArray = np.empty((num_draws, num_chains))
        accepted = np.empty(height.shape, dtype=bool)
        for k in range(num_draws):
            state, rate = self._walk(posterior, state, step, rng)
            state, accepted[k] = sweep.draw(state, rng)
            rates.append(rate)
            kept[k], height[k] = state
        if sweep.direct:
            height = posterior.log_prob(kept)
        facts: dict[str, float] = {"warmup": self.warmup}
        if posterior.noise_prior:
            facts |= {"noise_acceptance": float(np.mean(rates)), "noise_step": step}
        return Draws(
            posterior,
            posterior.natural(np.swapaxes(kept, 0, 1)),
            sampler=repr(self),
            stats={"log_prob": height.T, "accepted": accepted.T},
            facts=facts,
        )

    def _walk(
        self, posterior: Posterior, state: _State, step: float, rng: np.random.Generator
    ) -> tuple[_State, float]:
        """Random walk in the noise parameters alone, shaped by their Laplace covariance."""
        if not posterior.noise_prior:
            return state, TARGET
        p = posterior.dim_theta
        precision = np.linalg.inv(posterior.laplace.covariance)[p:, p:]
        root = np.linalg.cholesky(np.linalg.inv(precision))
        x, log_prob, taken = state.x, posterior.log_prob(state.x), 0.0
        length = step * 2.4 / np.sqrt(len(root))
        for _ in range(self.walks):
            proposed = x.copy()
            proposed[:, p:] += length * rng.standard_normal((len(x), len(root))) @ root.T
            height = posterior.log_prob(proposed)
            accepted = np.log(rng.random(len(x))) < height - log_prob
            x = np.where(accepted[:, None], proposed, x)
            log_prob = np.where(accepted, height, log_prob)
            taken += float(accepted.mean()) / self.walks
        return _State(x, log_prob), taken


class _Sweep:
    """Draw precisions given the unknowns, then the unknowns given the precisions."""

    def __init__(self, posterior: Posterior) -> None:
        self.posterior = posterior
        self.linear: Whitened = posterior.linear.whitened()
        # the Gaussian draw is the answer itself where rows are linear and nothing is cut off
        exact = posterior.problem.exact
        self.direct = (exact is None or posterior.problem.linear) and posterior.box is None
        p = posterior.dim_theta
        A = self.linear.A
        self.componentwise = posterior.noise.componentwise
        if self.componentwise:
            A = A.reshape(-1, 1, p)
            v = self.linear.v.reshape(-1, 1)
        else:
            v = self.linear.v
        self.squares = np.einsum("nmp,nmq->npq", A, A).reshape(len(A), p * p)
        self.moments = np.einsum("nmp,nm->np", A, v)
        prior = posterior.prior
        self.prior_precision, self.prior_moment = np.zeros((p, p)), np.zeros(p)
        if prior is not None:
            root = prior.root_precision
            self.prior_precision = root.T @ root
            self.prior_moment = self.prior_precision @ prior.mean

    def draw(self, state: _State, rng: np.random.Generator) -> tuple[_State, BoolArray]:
        """One sweep of all chains."""
        posterior, p = self.posterior, self.posterior.dim_theta
        theta = state.x[:, :p]
        rows = posterior.rows
        v = rows.residual(theta)
        precision = self._precisions(v, state.x, rng)
        flat = precision.reshape(len(theta), -1)
        matrix = (flat @ self.squares).reshape(-1, p, p) + self.prior_precision
        right = flat @ self.moments + self.prior_moment
        scale = np.sqrt(np.einsum("kpp->kp", matrix))
        root = np.linalg.cholesky(matrix / (scale[:, :, None] * scale[:, None, :]))
        mean = np.linalg.solve(root, (right / scale)[..., None])
        z = mean + rng.standard_normal(mean.shape)
        new = np.linalg.solve(np.swapaxes(root, 1, 2), z)[..., 0] / scale
        accepted = np.ones(len(theta), dtype=bool)
        if not self.direct:
            per_row = precision if precision.ndim == 3 else precision[..., None]
            moved = rows.residual(new)
            gain = self._excess(new, moved, per_row) - self._excess(theta, v, per_row)
            inside = posterior.inside(new)
            accepted = inside & (np.log(rng.random(len(theta))) < gain)
            new = np.where(accepted[:, None], new, theta)
        x = np.concatenate([new, state.x[:, p:]], axis=1)
        if self.direct:
            return _State(x, state.log_prob), accepted
        return _State(x, posterior.log_prob(x)), accepted

    def _precisions(self, v: FloatArray, x: FloatArray, rng: np.random.Generator) -> FloatArray:
        law = self.posterior.law(x)
        assert isinstance(law, ScaleMixture)
        return law.draw_precision(rng, v, self.posterior.rows.size)

    def _excess(self, theta: FloatArray, v: FloatArray, precision: FloatArray) -> FloatArray:
        """Log density of the exact rows over that of the linear ones, given the precisions."""
        linear = self.linear.residual(theta)
        return -0.5 * np.sum(precision * (v**2 - linear**2), axis=(-1, -2))
