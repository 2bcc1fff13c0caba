"""What a Metropolis-Hastings sampler asks of a move."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from probreg.posterior.posterior import Posterior
from probreg.typing import FloatArray


class Proposal(Protocol):
    """A move made ready for one posterior."""

    @property
    def target(self) -> float | None:
        """Acceptance rate that warm-up tunes the step to; None where there is no step."""

    def propose(
        self, x: FloatArray, step: float, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Proposed states (k, d) for states (k, d), and log q(x | y) - log q(y | x), (k,)."""


class Move(Protocol):
    """Settings of a move."""

    @property
    def share(self) -> float:
        """How often it is chosen, relative to the other moves."""

    def ready(self, posterior: Posterior, gamma: float) -> Proposal:
        """Make it ready for a posterior sharpened by gamma."""
