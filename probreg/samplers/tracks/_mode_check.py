"""Whether the normal posterior at the mode agrees with short chains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.posterior.tracks import TrackFit, fit_tracks
from probreg.posterior.tracks.steps import MANY_REPORTS, some_targets
from probreg.samplers.tracks._draws import TrackDraws
from probreg.samplers.tracks.gibbs_tracks import GibbsTracks
from probreg.typing import FloatArray

SWEEPS = 50
SOME_REPORTS = 8_000  # of more than 20 000
ALLOWED = 0.05  # of the standard deviation, of a scale or a shift


@dataclass(frozen=True, eq=False)
class ModeCheck:
    """The mode beside chains, on some 20 000 reports at most.

    Attributes
    ----------
    fit : TrackFit
        The mode of the reports that were sampled.
    draws : TrackDraws
    """

    fit: TrackFit
    draws: TrackDraws

    @property
    def sd_ratio(self) -> FloatArray:
        """Standard deviations at the mode over those of the chains, (p,)."""
        return np.asarray(self.fit.sd / self.draws.sd)

    @property
    def shift(self) -> FloatArray:
        """Mode less mean of the chains, in the chains' standard deviations, (p,)."""
        return np.asarray((self.fit.theta - self.draws.mean) / self.draws.sd)

    @property
    def shift_error(self) -> FloatArray:
        """Monte-Carlo standard error of `shift`, (p,), of sweeps that remember only the last."""
        means = self.draws.conditional_mean
        away = means - means.mean(axis=1, keepdims=True)
        variance = (away**2).mean(axis=(0, 1))
        alike = (away[:, 1:] * away[:, :-1]).mean(axis=(0, 1)) / np.maximum(variance, 1e-300)
        alike = np.clip(alike, 0.0, 0.95)
        sweeps = means.shape[0] * means.shape[1] * (1.0 - alike) / (1.0 + alike)
        return np.asarray(np.sqrt(variance / sweeps) / self.draws.sd)

    @property
    def agrees(self) -> bool:
        """Whether no scale and no mean is off by more than 5 % of the standard deviation.

        A mean may be off by two of its Monte-Carlo errors more.
        """
        far = np.abs(self.shift) - 2.0 * self.shift_error
        off = np.concatenate([np.abs(self.sd_ratio - 1.0), far])
        return bool(off.max(initial=0.0) <= ALLOWED)


def check_mode(fit: TrackFit, rng: np.random.Generator, sweeps: int = SWEEPS) -> ModeCheck:
    """Run a short chain from the mode.

    Of the whole recording if it has at most some 20 000 reports, else of whole targets with some
    8 000: chains take 1 microsecond a report and sweep.
    """
    count = fit.model.reports.counts
    among = some_targets(count, SOME_REPORTS) if count.sum() > MANY_REPORTS else None
    part = fit if among is None else fit_tracks(fit.model.of_targets(among), near=fit)
    return ModeCheck(part, GibbsTracks().sample(part, sweeps, 1, rng))
