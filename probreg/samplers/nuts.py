"""The no-U-turn sampler, in Pyro."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from probreg import extras
from probreg.arviz_adapter import MIN_DRAWS
from probreg.errors import InvalidInputError
from probreg.posterior.posterior import Posterior
from probreg.posterior.torch_bridge import as_torch, borrowed_torch
from probreg.samplers._draws import Draws
from probreg.samplers._start import require_target, start_states
from probreg.typing import FloatArray


@dataclass(frozen=True)
class Nuts:
    """NUTS on the posterior whitened by its Laplace approximation, with the analytic gradient.

    Chains run one after the other, each with its own seed, so that results do not depend on
    the number of cores. The states of torch, numpy and random are left as they were found.

    Parameters
    ----------
    warmup : int
        Steps in which step size and mass matrix are adapted.
    target_accept : float
        In (0, 1); nearer to one where there are divergences.
    max_tree_depth : int
    progress : bool
        Show Pyro's progress bar.
    """

    warmup: int = 100
    target_accept: float = 0.7
    max_tree_depth: int = 10
    progress: bool = False

    def __post_init__(self) -> None:
        if self.warmup < 1 or self.max_tree_depth < 1 or not 0.0 < self.target_accept < 1.0:
            raise InvalidInputError(
                f"Nuts: warmup {self.warmup} and max_tree_depth {self.max_tree_depth} must be 1 or "
                f"more, target_accept {self.target_accept} in (0, 1)."
            )

    def sample(
        self, posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> Draws:
        """Draw chain by chain, each seeded from the generator.

        `stats` has "diverging" too; `facts` the warm-up and the step size of each chain.

        Raises
        ------
        InvalidInputError
            Also where a box cuts the posterior: the gradient does not see it; or fewer draws
            than convergence can be judged by.
        MissingExtraError
            Torch or Pyro are not installed.
        """
        extras.require("nuts", "Nuts")
        require_target(posterior, num_draws, num_chains, rng)
        if num_draws < MIN_DRAWS:
            raise InvalidInputError(f"Nuts needs at least {MIN_DRAWS} draws a chain.")
        if posterior.box is not None:
            raise InvalidInputError(
                "Nuts follows the gradient, which does not see a box. Take MetropolisHastings, or "
                "say in a prior what the box says."
            )
        laplace = posterior.laplace
        root = laplace.root

        def potential(z: FloatArray) -> tuple[float, FloatArray]:
            value, slope = posterior.log_prob_and_grad(laplace.mean + root @ z)
            return -float(value), -(slope @ root)

        starts, _ = start_states(posterior, num_chains, rng)
        kept = np.empty((num_chains, num_draws, posterior.dim))
        diverging = np.zeros((num_chains, num_draws), dtype=bool)
        sizes = []
        for c, start in enumerate(starts):
            z = np.linalg.solve(root, start - laplace.mean)
            seed, target = int(rng.integers(2**31)), as_torch(potential)
            draws, bad, size = run_chain(self, target, z, num_draws, seed, full_mass=True)
            kept[c] = laplace.mean + draws @ root.T
            diverging[c, bad] = True
            sizes.append(size)
        stats = {"log_prob": posterior.log_prob(kept), "diverging": diverging}
        return Draws(
            posterior,
            posterior.natural(kept),
            sampler=repr(self),
            stats=stats,
            facts={"warmup": self.warmup, "step_size": sizes},
        )


def run_chain(
    settings: Nuts, potential: Any, start: FloatArray, num_draws: int, seed: int, *, full_mass: bool
) -> tuple[FloatArray, list[int], float]:
    """One seeded chain of a torch potential: draws (num_draws, d), diverging ones, step size."""
    import torch
    from pyro.infer.mcmc import MCMC, NUTS

    with borrowed_torch(seed):
        kernel = NUTS(
            potential_fn=lambda state: potential(state["z"]),
            full_mass=full_mass,
            adapt_mass_matrix=full_mass,
            target_accept_prob=settings.target_accept,
            max_tree_depth=settings.max_tree_depth,
        )
        run = MCMC(
            kernel,
            num_samples=num_draws,
            warmup_steps=settings.warmup,
            initial_params={"z": torch.tensor(start)},
            num_chains=1,
            disable_progbar=not settings.progress,
        )
        run.run()
        draws = run.get_samples()["z"].numpy()
        found = run.diagnostics()["divergences"]["chain 0"]
        # those of warm-up have negative numbers
        return draws, [k for k in found if 0 <= k < num_draws], float(kernel.step_size)
