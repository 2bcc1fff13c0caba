"""Have the chains mixed? What R-hat and effective sample sizes say, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtri

from probreg.arviz_adapter import MIN_DRAWS, Convergence, convergence
from probreg.typing import FloatArray

R_HAT = 1.01
FEW = 400  # effective draws below which quantiles are rough (Vehtari et al. 2021)
_FALSE_ALARM = 0.01  # that the largest R-hat of many is above its limit by chance


def unmixed(
    draws: FloatArray, labels: Sequence[str], found: Convergence | None = None
) -> list[str]:
    """What is wrong with draws (chain, draw, q) of a few unknowns; empty if nothing.

    Parameters
    ----------
    draws : ndarray, shape (chain, draw, q)
    labels : sequence of str
    found : Convergence, optional
        Of these draws, where it is known.
    """
    if draws.shape[1] < MIN_DRAWS:
        return ["too few draws a chain to judge convergence."]
    found = convergence(draws) if found is None else found
    said, least = _one_chain(draws), _effective(found)
    k, over = _worst(found.r_hat, R_HAT)
    if over:
        worst = f"R-hat is {found.r_hat[k]:.3f} for {labels[k]}"
        said.append(f"{worst}: the chains have not mixed; run longer.")
    if least.min() < FEW:
        said.append(f"only {least.min():.0f} effective draws (bulk or tail); run longer.")
    return said


def unmixed_among_many(draws: FloatArray, labels: Sequence[str]) -> list[str]:
    """The same of draws of very many unknowns, of which some look bad by chance.

    An R-hat counts where it exceeds what chance would leave anywhere; of those that do, the
    worst is named and all are counted. Draws that never moved count for none.
    """
    if draws.shape[1] < MIN_DRAWS:
        return ["too few draws a chain to judge convergence."]
    found = convergence(draws)
    least = np.where(np.ptp(draws, axis=(0, 1)) == 0.0, 0.0, _effective(found))
    said, many = _one_chain(draws), len(labels)
    k, over = _worst(found.r_hat, r_hat_limits(least, len(draws)))
    if over:
        worst = f"R-hat is {found.r_hat[k]:.3f} for {labels[k]} ({over} of {many} are too large)"
        said.append(f"{worst}: the chains have not mixed; run longer.")
    few, k = int((least < FEW).sum()), int(np.argmin(least))
    if few:
        fewest = f"only {least[k]:.0f} effective draws (bulk or tail) for {labels[k]}"
        said.append(f"{fewest} ({few} of {many} have fewer than {FEW}); run longer.")
    return said


def r_hat_limits(ess: FloatArray, chains: int) -> FloatArray:
    """Limits that R-hats of mixed chains exceed, anywhere among them, once in a hundred.

    Means of halves of chains scatter by chance: with m halves R-hat^2 is about
    1 + (m / ess) chi^2_(m-1) / (m - 1). Each unknown has two, of its bulk and of its tails.

    Parameters
    ----------
    ess : ndarray, shape (q,)
        Effective draws of each; the limit does not rise where they are too few.
    chains : int
    """
    halves, tests = 2 * chains, 2 * len(ess)
    top = float(chdtri(halves - 1.0, _FALSE_ALARM / tests)) / (halves - 1.0)
    return np.maximum(R_HAT, np.sqrt(1.0 + top * halves / np.maximum(ess, FEW)))


def _one_chain(draws: FloatArray) -> list[str]:
    return ["one chain: there is no other to compare it with."] if len(draws) == 1 else []


def _effective(found: Convergence) -> FloatArray:
    """Effective draws of bulk or tail, whichever are fewer; none of what cannot be judged."""
    return np.nan_to_num(np.minimum(found.ess_bulk, found.ess_tail))


def _worst(r_hat: FloatArray, limit: FloatArray | float) -> tuple[int, int]:
    """Which R-hat is the furthest above its limit, and how many are above; constants have none."""
    excess = np.where(np.isnan(r_hat), -np.inf, r_hat - limit)
    return int(np.argmax(excess)), int((excess > 0.0).sum())
