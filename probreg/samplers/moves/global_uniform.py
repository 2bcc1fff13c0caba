"""A uniform draw from a box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.posterior.posterior import Posterior
from probreg.samplers.moves._move import Proposal
from probreg.typing import FloatArray
from probreg.validation import positive_number


@dataclass(frozen=True, eq=False)
class GlobalUniform:
    """Anywhere in a box, whatever the current state: the global move of the MH paper.

    It is seldom accepted: less than once in a hundred tries where four unknowns are known to a
    tenth of the box. `LaplaceT` is the global move that works; this one is the paper's.

    Parameters
    ----------
    box : ndarray, shape (d, 2), optional
        Lower and upper bounds of the free coordinates; by default the posterior's own box,
        and for noise parameters and where there is none ten Laplace standard deviations.
    share : float
        How often the move is chosen, relative to the others.
    """

    box: FloatArray | None = None
    share: float = 0.05

    def __post_init__(self) -> None:
        positive_number("share of GlobalUniform", self.share)

    def ready(self, posterior: Posterior, gamma: float) -> Proposal:
        """Settle the box.

        Raises
        ------
        InvalidInputError
            The box has the wrong shape, is empty or excludes the mode.
        """
        mode, sd = posterior.laplace.mean, np.sqrt(np.diag(posterior.laplace.covariance))
        if self.box is not None:
            box = np.asarray(self.box, dtype=float)
            fits = box.shape == (posterior.dim, 2) and bool(np.isfinite(box).all())
            if not fits or not np.all(box[:, 0] < box[:, 1]):
                raise InvalidInputError(
                    f"box of GlobalUniform must be ({posterior.dim}, 2), finite, lower below upper."
                )
        else:
            box = np.stack([mode - 10.0 * sd, mode + 10.0 * sd], axis=1)
            if posterior.box is not None:
                finite = np.isfinite(posterior.box)
                own = box[: posterior.dim_theta]
                box[: posterior.dim_theta] = np.where(finite, posterior.box, own)
        if np.any(mode < box[:, 0]) or np.any(mode > box[:, 1]):
            raise InvalidInputError(
                f"the box of GlobalUniform excludes the mode {np.round(mode, 6).tolist()}: the "
                "chains would leave it and never return by this move. Widen it."
            )
        return _Anywhere(box)


@dataclass(frozen=True, eq=False)
class _Anywhere:
    box: FloatArray
    target: float | None = None

    def propose(
        self, x: FloatArray, step: float, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Draw from the box; from a state outside it there is no way back, so none out."""
        low, high = self.box.T
        inside = ((x >= low) & (x <= high)).all(axis=1)
        return rng.uniform(low, high, x.shape), np.where(inside, 0.0, -np.inf)
