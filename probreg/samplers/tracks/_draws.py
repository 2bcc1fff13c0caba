"""Draws of a track posterior."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from probreg.noise import ScaleMixture
from probreg.typing import FloatArray


@dataclass(frozen=True, eq=False)
class TrackDraws:
    """Draws of the biases with the moments they have given everything else.

    Attributes
    ----------
    theta : ndarray, shape (chains, draws, p)
    conditional_mean : ndarray, shape (chains, draws, p)
    conditional_covariance : ndarray, shape (chains, draws, p, p)
        Of the biases given precisions, identities, laws and accelerations, paths integrated out.
    acceleration : ndarray, shape (chains, draws)
    constant_sd : ndarray, shape (chains, draws, c)
    wrong_share : ndarray, shape (chains, draws, sensors)
    laws : tuple of tuple of tuple of ScaleMixture
        Of each chain, draw and sensor.
    wrong, outlier : ndarray, shape (n,)
        Share of the draws in which each report is of another target; is noisier than the first
        Gaussian of its law.
    mean_state : ndarray, shape (n, size)
        Mean of the drawn states at each report.
    """

    theta: FloatArray
    conditional_mean: FloatArray
    conditional_covariance: FloatArray
    acceleration: FloatArray
    constant_sd: FloatArray
    wrong_share: FloatArray
    laws: tuple[tuple[tuple[ScaleMixture, ...], ...], ...]
    wrong: FloatArray
    outlier: FloatArray
    mean_state: FloatArray

    @cached_property
    def mean(self) -> FloatArray:
        """Posterior mean (p,), Rao-Blackwellised."""
        return np.asarray(self._means.mean(axis=0))

    @cached_property
    def covariance(self) -> FloatArray:
        """Posterior covariance (p, p): within given weights, and between them."""
        p = self.theta.shape[-1]
        within = self.conditional_covariance.reshape(-1, p, p).mean(axis=0)
        away = self._means - self.mean
        return np.asarray(within + away.T @ away / max(len(away) - 1, 1))

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def _means(self) -> FloatArray:
        return self.conditional_mean.reshape(-1, self.theta.shape[-1])
