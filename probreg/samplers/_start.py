"""What every sampler checks and where its chains start."""

from __future__ import annotations

import numpy as np

from probreg.errors import ImproperLawError, InvalidInputError
from probreg.posterior.posterior import Posterior
from probreg.samplers.moves.laplace_t import LaplaceT
from probreg.typing import FloatArray
from probreg.validation import sampling_run


def require_target(
    posterior: Posterior, num_draws: int, num_chains: int, rng: np.random.Generator
) -> None:
    """Raise unless there is a density to draw from and the numbers make sense.

    Raises
    ------
    ImproperLawError
        The noise law has no density.
    InvalidInputError
        Not a posterior or a generator, draws or chains below one.
    """
    if not isinstance(posterior, Posterior):
        raise InvalidInputError(f"a sampler takes a Posterior, not a {type(posterior).__name__}.")
    sampling_run(num_draws, num_chains, rng)
    if not posterior.noise.proper:
        raise ImproperLawError(
            f"{type(posterior.noise).__name__} is a rejection rule without a density, so there is "
            "no posterior to sample. Take Gaussian, StudentT, Contaminated, Hyperbolic or Huber."
        )


def start_states(
    posterior: Posterior, num_chains: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """States (k, d) about the mode, wider than the posterior, in the box; their log_prob (k,)."""
    mode = posterior.laplace.mean
    height = float(posterior.log_prob(mode))
    density = LaplaceT().ready(posterior, 1.0)
    x = density.sample(rng, num_chains)
    for _ in range(100):
        bad = ~posterior.inside(x)
        if not bad.any():
            break
        x[bad] = density.sample(rng, int(bad.sum()))
    x[~posterior.inside(x)] = mode
    log_prob = posterior.log_prob(x)
    # a start that the density cannot hold is put at the mode, which it can
    lost = ~np.isfinite(log_prob)
    x[lost], log_prob[lost] = mode, height
    return x, log_prob
