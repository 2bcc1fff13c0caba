"""A particle filter that samples only what the Kalman filter cannot integrate."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.special import logsumexp

from probreg.errors import InvalidInputError
from probreg.motion.trajectory import Trajectory
from probreg.noise import NoiseLaw, ScaleMixture, StudentT, per_component, require_scalar_law
from probreg.numerics import kalman
from probreg.numerics.resampling import systematic
from probreg.samplers.scans import _particles
from probreg.samplers.scans._target import require_scene
from probreg.samplers.scans._track import Track
from probreg.typing import FloatArray, IntArray


@dataclass(frozen=True)
class ParticleFilter:
    """Rao-Blackwellised particle filter for noise that is Gaussian given a hidden precision.

    A particle is a guess of the precisions of all rows so far; given them the state is
    Gaussian, and each particle carries its own Kalman filter. For use as reports come in: what
    it says of a scan rests on the scans up to it. Under Gaussian noise it is the Kalman
    filter, whatever the number of particles.

    Parameters
    ----------
    noise : NoiseLaw
        A scale mixture: Gaussian, StudentT, Contaminated, Hyperbolic.
    particles : int
    resample_below : float
        Share of effective particles below which they are resampled.
    draws : int
        Draws of the state kept for each scan.

    Raises
    ------
    InvalidInputError
        Numbers out of range, a law that is no scale mixture.

    References
    ----------
    Doucet, de Freitas, Murphy and Russell, Rao-Blackwellised particle filtering for dynamic
    Bayesian networks, UAI 2000.
    """

    noise: NoiseLaw = field(default_factory=StudentT)
    particles: int = 500
    resample_below: float = 0.5
    draws: int = 500

    def __post_init__(self) -> None:
        require_scalar_law(self.noise)
        if not isinstance(self.noise, ScaleMixture) or not self.noise.scale_mixture:
            raise InvalidInputError(
                f"{self.noise!r} is not a Gaussian given a hidden precision. Take ScanMetropolis."
            )
        if self.particles < 2 or self.draws < 2:
            raise InvalidInputError("at least two particles and two draws are needed.")
        if not 0.0 <= self.resample_below <= 1.0:
            raise InvalidInputError(f"resample_below is {self.resample_below}, not in [0, 1].")

    def track(self, model: Trajectory, rng: np.random.Generator) -> Track:
        """Follow the states by weighted particles.

        `facts` has "log_evidence", the estimated log marginal likelihood of all reports (its
        exponential is unbiased), "effective" (T,), the effective particles of each scan before
        resampling, and "particles", their number.
        """
        require_scene(model, rng)
        v, A, log_det = model.whitened
        T, d, N = len(model), len(model.names), self.particles
        x = np.tile(model.prior.mean, (N, 1))
        P = np.tile(model.prior.covariance, (N, 1, 1))
        log_weights, evidence = np.full(N, -np.log(N)), -0.5 * log_det
        mean, kept, effective = np.empty((T, d)), np.empty((T, self.draws, d)), np.empty(T)
        for t in range(T):
            if t:
                _particles.predict(x, P, np.array(model.F[t - 1]), np.array(model.Q[t - 1]))
            log_weights = log_weights + _particles.update(
                x, P, v[t], A[t], self._precisions(model, t, rng)
            )
            total = float(logsumexp(log_weights))
            if not np.isfinite(total):
                raise InvalidInputError(
                    f"no particle explains scan {t}, or the prior is too wide for double precision."
                )
            evidence, log_weights = evidence + total, log_weights - total
            share = np.exp(log_weights)
            mean[t], effective[t] = share @ x, 1.0 / np.sum(share**2)
            kept[t] = _draw(x, P, systematic(share, self.draws, rng), rng)
            if effective[t] < self.resample_below * N:
                chosen = systematic(share, N, rng)
                x, P, log_weights = x[chosen], P[chosen], np.full(N, -np.log(N))
        facts = {"log_evidence": evidence, "effective": effective, "particles": N}
        return Track(model, mean, kept, sampler=repr(self), facts=facts)

    def _precisions(self, model: Trajectory, t: int, rng: np.random.Generator) -> FloatArray:
        """Prior draws (N, m) of the precisions of a scan's components; zero if not reported."""
        noise = self.noise
        assert isinstance(noise, ScaleMixture)
        assert model.present is not None
        width = 1 if noise.componentwise else model.width
        sizes = model.present[t].reshape(-1, width).sum(axis=1).astype(int)
        drawn = np.zeros((self.particles, len(sizes), width))
        for size in np.unique(sizes[sizes > 0]):
            rows = np.flatnonzero(sizes == size)
            # a residual of the law and its precision given that are a joint draw
            residual = noise.sample(rng, self.particles * len(rows), int(size))
            precision = per_component(noise.draw_precision(rng, residual), residual)[:, 0]
            drawn[:, rows] = precision.reshape(self.particles, len(rows), 1)
        return drawn.reshape(self.particles, -1) * model.present[t]


def _draw(x: FloatArray, P: FloatArray, chosen: IntArray, rng: np.random.Generator) -> FloatArray:
    """One draw from the Gaussian of each chosen particle."""
    roots = {i: kalman.semidefinite_root(P[i]) for i in np.unique(chosen)}
    z = rng.standard_normal((len(chosen), x.shape[1]))
    return x[chosen] + np.array([roots[i] @ own for i, own in zip(chosen, z, strict=True)])
