"""Independent draws where the posterior is Gaussian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.noise import Gaussian
from probreg.posterior.posterior import Posterior
from probreg.samplers._draws import Draws
from probreg.samplers._start import require_target


@dataclass(frozen=True)
class Exact:
    """Closed form for Gaussian noise and linear rows: independent draws, no warm-up."""

    def sample(
        self, posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
    ) -> Draws:
        """Draw independently.

        Raises
        ------
        InvalidInputError
            Also where the posterior is not Gaussian: other noise, an unknown noise parameter,
            bearings, a box.
        """
        require_target(posterior, num_draws, num_chains, rng)
        require_gaussian(posterior)
        laplace = posterior.laplace
        z = rng.standard_normal((num_chains, num_draws, posterior.dim))
        theta = laplace.mean + z @ laplace.root.T
        return Draws(
            posterior, theta, sampler=repr(self), stats={"log_prob": posterior.log_prob(theta)}
        )


def require_gaussian(posterior: Posterior) -> None:
    """Raise unless the posterior is Gaussian in closed form."""
    reasons = {
        f"the noise is {type(posterior.noise).__name__}": not isinstance(posterior.noise, Gaussian),
        "a noise parameter is unknown": bool(posterior.noise_prior),
        "bearings are not linear in the position": posterior.problem.exact is not None
        and not posterior.problem.linear,
        "a box cuts it": posterior.box is not None,
    }
    for reason, holds in reasons.items():
        if holds:
            raise InvalidInputError(
                f"there is no closed form: {reason}. Take MetropolisHastings, Gibbs or Nuts."
            )
