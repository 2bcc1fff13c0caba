"""Metropolis-Hastings with mixed moves, many chains at once."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from probreg.errors import InvalidInputError
from probreg.posterior.posterior import Posterior
from probreg.samplers._draws import Draws
from probreg.samplers._start import require_target, start_states
from probreg.samplers.moves import LaplaceT, LocalGaussian, Move, Proposal
from probreg.typing import BoolArray, FloatArray, IntArray
from probreg.validation import positive_number


@dataclass(frozen=True)
class MetropolisHastings:
    """Metropolis-Hastings: a move is chosen, then accepted by its own Hastings ratio.

    All chains advance together, so many short chains cost little more than one. Proposals
    outside the posterior's box are rejected and the state repeated, never clipped.

    Parameters
    ----------
    moves : tuple of Move
        Chosen with probabilities proportional to their shares, for each chain and step.
    gamma : float
        Sharpening exponent: the target is the posterior to this power. Other than 1 the
        draws are not from the posterior, and their result says so.
    warmup : int
        Steps before the first draw; step lengths are tuned in them only.

    Raises
    ------
    InvalidInputError
        No move, gamma not above zero.
    """

    moves: tuple[Move, ...] = field(default_factory=lambda: (LaplaceT(), LocalGaussian()))
    gamma: float = 1.0
    warmup: int = 50

    def __post_init__(self) -> None:
        positive_number("gamma", self.gamma)
        if not self.moves or self.warmup < 0:
            raise InvalidInputError("at least one move, and a warmup of zero or more, are needed.")

    def sample(
        self, posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> Draws:
        """Draw from the posterior to the power gamma.

        `stats` has "accepted" and "move" (its number) too; `facts` the acceptance rate and the
        tuned step of each move.
        """
        require_target(posterior, num_draws, num_chains, rng)
        proposals = [move.ready(posterior, self.gamma) for move in self.moves]
        x, log_prob = start_states(posterior, num_chains, rng)
        steps = np.ones(len(proposals))
        for k in range(self.warmup):
            x, log_prob, accepted, which = self._step(posterior, proposals, steps, x, log_prob, rng)
            _tune(steps, proposals, accepted, which, k)
        kept = np.empty((num_draws, num_chains, posterior.dim))
        height = np.empty((num_draws, num_chains))
        taken, chosen = np.empty(height.shape, dtype=bool), np.empty(height.shape, dtype=int)
        for k in range(num_draws):
            x, log_prob, taken[k], chosen[k] = self._step(
                posterior, proposals, steps, x, log_prob, rng
            )
            kept[k], height[k] = x, log_prob
        kinds = [type(move).__name__ for move in self.moves]
        names = [kind if kinds.count(kind) == 1 else f"{kind}[{k}]" for k, kind in enumerate(kinds)]
        facts = {
            "acceptance": {n: _rate(taken[chosen == k]) for k, n in enumerate(names)},
            "step": dict(zip(names, steps.tolist(), strict=True)),
            "warmup": self.warmup,
        }
        stats = {"log_prob": height.T, "accepted": taken.T, "move": chosen.T}
        theta = posterior.natural(np.swapaxes(kept, 0, 1))
        return Draws(
            posterior, theta, sampler=repr(self), stats=stats, gamma=self.gamma, facts=facts
        )

    def _step(
        self,
        posterior: Posterior,
        proposals: list[Proposal],
        steps: FloatArray,
        x: FloatArray,
        log_prob: FloatArray,
        rng: np.random.Generator,
    ) -> tuple[FloatArray, FloatArray, BoolArray, IntArray]:
        shares = np.array([move.share for move in self.moves])
        which = rng.choice(len(proposals), size=len(x), p=shares / shares.sum())
        proposed, ratio = np.empty_like(x), np.empty(len(x))
        for k, proposal in enumerate(proposals):
            own = which == k
            if own.any():
                proposed[own], ratio[own] = proposal.propose(x[own], steps[k], rng)
        height = posterior.log_prob(proposed)
        # NaN compares false: a proposal without a density is rejected
        accepted = np.log(rng.random(len(x))) < self.gamma * (height - log_prob) + ratio
        x = np.where(accepted[:, None], proposed, x)
        return x, np.where(accepted, height, log_prob), accepted, which


def _tune(
    steps: FloatArray,
    proposals: list[Proposal],
    accepted: BoolArray,
    which: IntArray,
    iteration: int,
) -> None:
    """Move each step length towards its target rate, in place, less and less."""
    for k, proposal in enumerate(proposals):
        own = accepted[which == k]
        if proposal.target is not None and own.size:
            gain = 2.0 * (iteration + 1.0) ** -0.6
            steps[k] *= np.exp(gain * (own.mean() - proposal.target))


def _rate(accepted: BoolArray) -> float:
    return float(accepted.mean()) if accepted.size else float("nan")
