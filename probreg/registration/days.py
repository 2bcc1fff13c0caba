"""Many registrations of the same sensors, day by day: what they share, and what varies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from probreg.errors import InvalidInputError
from probreg.registration.hierarchy import Pooled, pool
from probreg.registration.saved import BIASES, SavedResult, ordered, read, refuse_others
from probreg.typing import BoolArray, FloatArray

DRAWS = 4_000
LEAST_SHARE = 0.1  # of a bias determined by the data, below which a day says nothing of it
SPREAD = 0.25  # scale of the spread between days, in prior standard deviations of the bias


@dataclass(frozen=True, eq=False)
class Days:
    """Results of several recordings, in order of time.

    Attributes
    ----------
    results : tuple of SavedResult
    pooled : tuple of Pooled or None
        Of each bias; None where fewer than two days say anything of it.
    used : ndarray of bool, shape (n, p)
        Which days say something of which bias.
    prior_sd : ndarray, shape (p,)
        Of each bias, as the registrations had it.
    """

    results: tuple[SavedResult, ...]
    pooled: tuple[Pooled | None, ...]
    used: BoolArray
    prior_sd: FloatArray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the biases."""
        return self.results[0].names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the biases, SI."""
        return self.results[0].units

    @property
    def mean(self) -> FloatArray:
        """Posterior means, shape (n, p)."""
        return np.array([result.mean for result in self.results])

    @property
    def sd(self) -> FloatArray:
        """Posterior standard deviations, shape (n, p)."""
        return np.array([result.sd for result in self.results])

    @property
    def times(self) -> FloatArray:
        """Starts of the recordings (n,); their numbers where some have none, or share one."""
        starts = np.array([result.start for result in self.results])
        known = np.isfinite(starts).all() and len(np.unique(starts)) == len(starts)
        return starts if known else np.arange(1.0, len(starts) + 1.0)


def read_days(folder: str | Path) -> tuple[SavedResult, ...]:
    """Results in the folders of a folder, in order of time, or of name where times are the same.

    Raises
    ------
    InvalidInputError
        Fewer than two, or of different sensors.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InvalidInputError(f"{folder} is no folder; name one that holds folders of results.")
    inside = sorted(path for path in folder.iterdir() if (path / BIASES).is_file())
    if len(inside) < 2:
        raise InvalidInputError(
            f"{folder} holds {len(inside)} folders with a {BIASES}; two or more are needed, one a "
            "recording."
        )
    results = [read(path) for path in inside]
    refuse_others(results)
    results = [ordered(result, results[0].names) for result in results]
    starts = np.array([result.start for result in results])
    if np.isfinite(starts).all():
        results = [results[k] for k in np.argsort(starts, kind="stable")]
    return tuple(results)


def pool_days(results: Sequence[SavedResult], rng: np.random.Generator) -> Days:
    """Pool each bias over recordings, the prior of each registration taken out of it.

    Parameters
    ----------
    results : sequence of SavedResult
        Of the same sensors and terms.
    rng : numpy.random.Generator
    """
    mean, sd, share = (
        np.array([getattr(result, name) for result in results]) for name in ("mean", "sd", "share")
    )
    used = share >= LEAST_SHARE
    with np.errstate(divide="ignore"):
        prior_sd = np.median(sd / np.sqrt(np.clip(1.0 - share, 0.0, None)), axis=0)
    # all but certain: any wide prior does
    wide = 1e3 * (np.abs(mean).max(axis=0) + sd.max(axis=0))
    prior_sd = np.where(np.isfinite(prior_sd), prior_sd, wide)
    pooled: list[Pooled | None] = []
    for k in range(mean.shape[1]):
        days = np.flatnonzero(used[:, k])
        if len(days) < 2:
            pooled.append(None)
            continue
        # a normal posterior less its normal prior about zero
        data = share[days, k]
        pooled.append(
            pool(
                mean[days, k] / data,
                sd[days, k] / np.sqrt(data),
                common_sd=float(prior_sd[k]),
                spread_sd=SPREAD * float(prior_sd[k]),
                num_draws=DRAWS,
                rng=rng,
            )
        )
    return Days(tuple(results), tuple(pooled), used, prior_sd)
