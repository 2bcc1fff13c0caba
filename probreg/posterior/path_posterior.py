"""The posterior of a whole path under any proper noise law."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.errors import ImproperLawError, InvalidInputError
from probreg.motion.trajectory import Backward, Trajectory
from probreg.noise import Gaussian, NoiseLaw, per_component, require_scalar_law
from probreg.typing import BoolArray, FloatArray, IntArray

_MAX_PASSES = 200


@dataclass(frozen=True, eq=False)
class PathPosterior:
    """Posterior of the path of a linear-Gaussian state whose rows have a noise law.

    It is read in coordinates z in which a Gaussian reference is standard normal: the exact
    posterior with each row's noise Gaussian and weighted as at the mode. In z the posterior
    is the standard normal times the ratio of the rows' densities to their Gaussian stand-ins,
    so no step's density is needed and Q may be singular.

    Parameters
    ----------
    trajectory : Trajectory
    noise : NoiseLaw
        Of the whitened rows. R is its scale matrix.

    Raises
    ------
    ImproperLawError
        The law has no density.
    """

    trajectory: Trajectory
    noise: NoiseLaw

    def __post_init__(self) -> None:
        require_scalar_law(self.noise)
        if not self.noise.proper:
            raise ImproperLawError(
                f"{type(self.noise).__name__} has no density, so a path has no posterior under it. "
                "Take Gaussian, StudentT, Contaminated, Hyperbolic or Huber."
            )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the d states."""
        return self.trajectory.names

    @property
    def shape(self) -> tuple[int, int]:
        """(T, d)."""
        return len(self.trajectory), len(self.names)

    def residual(self, path: FloatArray) -> FloatArray:
        """Whitened residuals of the rows, shape (..., T * rows, width), for path (..., T, d)."""
        path = np.asarray(path, dtype=float)
        if path.shape[-2:] != self.shape:
            raise InvalidInputError(
                f"path has shape {path.shape}; its last axes must be {self.shape}."
            )
        v, A, _ = self.trajectory.whitened
        left = v - np.einsum("tmd,...td->...tm", A, path)
        return left.reshape(*path.shape[:-2], -1, self._width)

    def log_likelihood(self, path: FloatArray) -> FloatArray:
        """Log-density of each reported row, shape (..., n), whitened coordinates."""
        v = self.residual(path)[..., self._reported, :]
        return self.noise.log_density(v, self._sizes)

    def weights(self, path: FloatArray) -> FloatArray:
        """Equivalent weights of components, shape (..., T, m); zero where none was reported."""
        v = self.residual(path)
        assert self.trajectory.present is not None
        weight = per_component(self.noise.weight(v, np.maximum(self.row_sizes, 1)), v)
        return weight.reshape(*v.shape[:-2], *self.trajectory.y.shape) * self.trajectory.present

    @cached_property
    def mode_weights(self) -> FloatArray:
        """Weights (T, m) at the mode of the path, by reweighted smoothing.

        For laws with several modes the start is the mode under Gaussian noise of the law's
        own spread.
        """
        model = self.trajectory
        weights = np.array(model.present, dtype=float)
        for _ in range(_MAX_PASSES):
            path = model.smooth(model.filter(weights)).mean
            before, weights = weights, self.weights(path)
            if np.abs(weights - before).max() < 1e-6 * max(1.0, float(weights.max())):
                break
        return weights

    @cached_property
    def reference_weights(self) -> FloatArray:
        """Weights (T, m) of the Gaussian stand-ins: those at the mode, where not too trusting.

        A row that fits the mode by chance has the law's full weight there, more than the law
        is curved on average; a reference so narrow would hide the tails from its samplers.
        """
        if isinstance(self.noise, Gaussian):
            return self.mode_weights
        cap = 0.5 * self.noise.information_factor(self._width)
        return np.minimum(self.mode_weights, cap)

    @cached_property
    def reference(self) -> Backward:
        """The Gaussian reference as a map of standard normal numbers."""
        return self.trajectory.backward(self.trajectory.filter(self.reference_weights))

    def log_ratio(self, path: FloatArray) -> FloatArray:
        """Log of the rows' densities over their Gaussian stand-ins, up to a constant, (...)."""
        v = self.residual(path)
        stand_in = -0.5 * (self.reference_weights.reshape(-1, v.shape[-1]) * v**2).sum(
            axis=(-1, -2)
        )
        return self.log_likelihood(path).sum(axis=-1) - stand_in

    def log_prob_and_grad(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Log-posterior of coordinates z (k, T, d), up to a constant, (k,), and its gradient."""
        path = self.reference.paths(z)
        v = self.residual(path)
        excess = self.weights(path) - self.reference_weights
        pulled = excess * v.reshape(*path.shape[:-1], -1)
        slope = np.einsum("ktm,tmd->ktd", pulled, self.trajectory.whitened[1])
        value = self.log_ratio(path) - 0.5 * np.einsum("ktd,ktd->k", z, z)
        return value, self.reference.pull_back(slope) - z

    @property
    def _width(self) -> int:
        """Components of a row; for component-wise laws every component is one."""
        return 1 if self.noise.componentwise else self.trajectory.width

    @cached_property
    def row_sizes(self) -> IntArray:
        """Reported components of each row, shape (T * rows,)."""
        assert self.trajectory.present is not None
        flat = self.trajectory.present.reshape(-1, self._width)
        return flat.sum(axis=1).astype(int)

    @cached_property
    def _reported(self) -> BoolArray:
        return self.row_sizes > 0

    @cached_property
    def _sizes(self) -> IntArray:
        return self.row_sizes[self._reported]
