"""The per-scan Metropolis-Hastings tracker of the MH paper, and what makes it right."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from probreg.errors import ImproperLawError, InvalidInputError
from probreg.motion.trajectory import Trajectory
from probreg.noise import Gaussian, NoiseLaw, require_scalar_law
from probreg.numerics import kalman
from probreg.samplers.scans._scan_chain import Rows, Walk, run_scan
from probreg.samplers.scans._target import Memory, ScanPrior, ScanTarget, require_scene
from probreg.samplers.scans._track import Track
from probreg.samplers.scans.targets import Flat
from probreg.typing import FloatArray
from probreg.validation import finite_array, positive_number


@dataclass(frozen=True, eq=False)
class ScanMetropolis:
    """A Metropolis-Hastings chain within each scan, started where the last one ended.

    With probability `share_global` a proposal is uniform over the box, else a Gaussian step.
    Both are symmetric, so acceptance needs no other ratio; proposals outside the box are
    rejected. The paper's protocol is
    `ScanMetropolis(Flat(), steps=50, burn_in=0, step=20.0, gamma=10.0, estimate="last")`.

    Parameters
    ----------
    target : ScanTarget
        What a scan takes over from those before: `Flat`, `GaussianMemory`, `ParticleMemory`,
        `AccumulatedMemory`, `AllScans`; `AsPrinted` shows the paper's printed density.
    noise : NoiseLaw
    steps, burn_in : int
        Proposals a scan, and how many of the first states are left out.
    step : float or ndarray, shape (d,), optional
        Standard deviation of a local step; by default 2.38 / sqrt(d) times the root of the
        posterior covariance of one scan with what it takes over.
    share_global : float
        beta, in [0, 1].
    gamma : float
        Sharpening exponent; other than 1 the draws are not from the posterior.
    box : float or ndarray, shape (d, 2), optional
        Bounds of the unknowns (a number means plus and minus); by default eight prior standard
        deviations about the prior's mean, widest over the scans.
    start : ndarray, shape (d,), optional
        First state; by default the prior's mean.
    warm_start : bool
        Begin each scan where the last one ended, or at `start`.
    estimate : {"mean", "last"}
        Chain mean after burn-in, or the paper's last state.

    Raises
    ------
    InvalidInputError
        Settings out of range.
    ImproperLawError
        The law has no density.

    References
    ----------
    Zhou, Liang and Pan, Systems Engineering and Electronics 34(3), 2012, section 3.
    """

    target: ScanTarget = field(default_factory=Flat)
    noise: NoiseLaw = field(default_factory=Gaussian)
    steps: int = 1000
    burn_in: int = 200
    step: FloatArray | float | None = None
    share_global: float = 0.1
    gamma: float = 1.0
    box: FloatArray | float | None = None
    start: FloatArray | None = None
    warm_start: bool = True
    estimate: Literal["mean", "last"] = "mean"

    def __post_init__(self) -> None:
        require_scalar_law(self.noise)
        if not self.noise.proper:
            raise ImproperLawError(f"{type(self.noise).__name__} has no density to sample.")
        positive_number("gamma", self.gamma)
        if not 0 <= self.burn_in < self.steps:
            raise InvalidInputError(
                f"steps {self.steps} must be above burn_in {self.burn_in}, which is zero or more."
            )
        if not 0.0 <= self.share_global <= 1.0:
            raise InvalidInputError(f"share_global is {self.share_global}, not in [0, 1].")
        if not isinstance(self.target, ScanTarget):
            raise InvalidInputError(f"target is {self.target!r}; an instance, as in Flat().")
        step = np.asarray(1.0 if self.step is None else self.step, dtype=float)
        if step.ndim > 1 or not (np.isfinite(step).all() and (step > 0.0).all()):
            raise InvalidInputError(f"step is {self.step}; one number or (d,), above zero.")
        if self.estimate not in ("mean", "last"):
            raise InvalidInputError(f"estimate is {self.estimate!r}; 'mean' or 'last'.")

    def track(self, model: Trajectory, rng: np.random.Generator) -> Track:
        """Follow the states by a chain a scan.

        `draws` are those of every scan after burn-in. `facts` has "acceptance" (T,) and
        "at_edge", the number of scans whose draws reach within a hundredth of the box from its
        edge.

        Raises
        ------
        InvalidInputError
            Also of a start outside the box, or a target that the noise does not go with.
        """
        self._check(model, rng)
        T, d = len(model), len(model.names)
        box = self._box(model)
        start = self._start(model, box)
        x = start.copy()
        kernel, numbers = self.noise.compiled_kernel, self.noise.numbers
        draws = np.empty((T, self.steps, d))
        accepted, memory = np.zeros(T), Memory(None)
        last = np.empty((T, d))
        for t in range(T):
            prior = self._prior(model, t, memory)
            if not self.warm_start:
                x[:] = start
            rows = self._rows(model, t)
            step = self._steps(rows.A, rows.size, prior)
            walk = Walk(box, self.share_global, step, self.gamma, self.target.sign)
            taken = run_scan(rng, rows, kernel, numbers, prior, walk, x, draws[t])
            accepted[t], last[t] = taken / self.steps, x
            memory = Memory(draws[t, self.burn_in :])
        kept = draws[:, self.burn_in :]
        mean = kept.mean(axis=1) if self.estimate == "mean" else last
        margin = 0.01 * (box[:, 1] - box[:, 0])
        near = (kept < box[:, 0] + margin) | (kept > box[:, 1] - margin)
        facts = {"acceptance": accepted, "at_edge": int(near.any(axis=(1, 2)).sum())}
        return Track(model, mean, kept, sampler=repr(self), gamma=self.gamma, facts=facts)

    def _check(self, model: Trajectory, rng: np.random.Generator) -> None:
        require_scene(model, rng)
        plain = isinstance(self.noise, Gaussian) and self.noise.unit == 1.0
        if self.target.gaussian_only and not plain:
            raise InvalidInputError(
                f"{type(self.target).__name__} keeps what scans say under Gaussian noise of scale "
                f"1; under {self.noise!r} take AllScans, or GaussianMemory for a drift."
            )

    def _rows(self, model: Trajectory, t: int) -> Rows:
        """Reported rows that a scan looks at."""
        v, A, _ = model.whitened
        assert model.present is not None
        width, d = 1 if self.noise.componentwise else model.width, A.shape[2]
        used = slice(self.target.first(t), t + 1)
        size = model.present[used].reshape(-1, width).sum(axis=1)
        seen = size > 0.0
        flat, slopes = v[used].reshape(-1, width)[seen], A[used].reshape(-1, width, d)[seen]
        return Rows(flat, slopes, size[seen])

    def _prior(self, model: Trajectory, t: int, memory: Memory) -> ScanPrior:
        try:
            found = self.target.prior(model, t, memory)
            return ScanPrior(np.ascontiguousarray(found.centres), found.root)
        except np.linalg.LinAlgError:
            raise InvalidInputError(
                f"the draws of scan {t - 1} span no volume: its chain hardly moved, and nothing "
                "drifts that would spread them. Take more steps, or AccumulatedMemory for "
                "unknowns that are constant."
            ) from None

    def _box(self, model: Trajectory) -> FloatArray:
        """Bounds (d, 2): given, or eight prior standard deviations about the prior's own path."""
        d = len(model.names)
        if self.box is None:
            mean, sd = model.prior_path()
            return np.stack([(mean - 8.0 * sd).min(axis=0), (mean + 8.0 * sd).max(axis=0)], axis=1)
        box = np.asarray(self.box, dtype=float)
        if box.ndim == 0:
            positive_number("box", float(box))
            return np.tile([-float(box), float(box)], (d, 1))
        fits = box.shape == (d, 2) and np.isfinite(box).all()
        if not fits or not np.all(box[:, 0] < box[:, 1]):
            raise InvalidInputError(
                f"box must be a number or ({d}, 2), all finite, lower below upper."
            )
        return box

    def _start(self, model: Trajectory, box: FloatArray) -> FloatArray:
        x = model.prior.mean if self.start is None else self.start
        start = finite_array("start", x, (len(model.names),))
        out = np.flatnonzero((start < box[:, 0]) | (start > box[:, 1]))
        if out.size:
            k = int(out[0])
            raise InvalidInputError(
                f"the chain would start at {start[k]:g} in {model.names[k]}, outside its box of "
                f"{box[k, 0]:g} to {box[k, 1]:g}. Widen the box, or leave it to the prior."
            )
        return start

    def _steps(self, A: FloatArray, size: FloatArray, prior: ScanPrior) -> FloatArray:
        """Root (d, d) of the steps' covariance: given, or of one scan with what it takes over."""
        d = A.shape[2]
        if self.step is not None:
            return np.diag(np.broadcast_to(np.asarray(self.step, dtype=float), (d,)))
        each = {m: self.noise.information_factor(int(m)) for m in np.unique(size)}
        factor = np.array([each[m] for m in size])
        precision = np.einsum("n,nma,nmb->ab", factor, A, A, optimize=True)
        if len(prior.centres):
            precision = precision + prior.root.T @ prior.root
        # unknowns of different units: pivots are judged on the correlation
        scale = np.sqrt(np.maximum(np.diag(precision), np.finfo(float).tiny))
        inverse = np.linalg.pinv(precision / np.outer(scale, scale), hermitian=True)
        covariance = inverse / np.outer(scale, scale)
        return 2.38 / np.sqrt(d * self.gamma) * kalman.semidefinite_root(covariance)
