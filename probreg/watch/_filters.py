"""Beliefs about biases that walk: filters of several walks, weighed by their evidence.

Filter 0 takes the estimated walk of every bias; filter 1 + c L + l takes level l for bias c. The
last one takes walks as they were estimated some time ago: that by which changes are judged, or
what changes now would be taken for the usual walk.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numba
import numpy as np

from probreg.prior import GaussianPrior
from probreg.typing import FloatArray
from probreg.watch.settings import WatchSettings
from probreg.watch.state import Filters

# of a walk in prior standard deviations a root minute, beside the constant: half the prior
SLOWEST, RATIO, LEVELS = 5e-4, 2.1, 9
PAST = 180  # slices whose evidence is remembered
# of the variance of a step that an alarm has widened: linear through its slice, beliefs take it
# too far or not far enough, by (1 / 45) / (1 / 3)^2 of its square
SETTLING = 0.2
HOUR_S, MINUTE_S = 3600.0, 60.0


class Belief(NamedTuple):
    """Biases at the newest knot under each filter.

    Attributes
    ----------
    mean, variance : ndarray, shape (F, p)
    log_evidence : ndarray, shape (F,)
    """

    mean: FloatArray
    variance: FloatArray
    log_evidence: FloatArray


def levels(settings: WatchSettings, prior_sd: FloatArray) -> FloatArray:
    """Variances of a step by level and bias, shape (L, p)."""
    least = settings.floor**2 * settings.slice_s / HOUR_S
    walk = np.zeros(1)
    if settings.drift:
        pace = SLOWEST * RATIO ** np.arange(LEVELS)
        walk = np.append(0.0, pace**2 * settings.slice_s / MINUTE_S)
    return np.asarray((least + walk)[:, None] * prior_sd**2)


def first_filters(prior: GaussianPrior, theta: FloatArray, settings: WatchSettings) -> Filters:
    """The prior at the oldest knot and walks from there, about theta."""
    p, W = theta.size, settings.window
    variance = levels(settings, np.sqrt(np.diag(prior.covariance)))
    L = len(variance)
    F = 2 + p * L if L > 1 else 1
    root = np.linalg.inv(prior.covariance)
    empty = Filters(
        np.zeros((F, W * p, W * p)),
        np.zeros((F, W * p)),
        np.zeros(F),
        np.ones((F, W, p)),
        np.zeros(F),
        np.zeros((0, F)),
    )
    empty.precision[:, -p:, -p:] = root
    empty.shift[:, -p:] = root @ (prior.mean - theta)
    found = empty
    for _ in range(W - 1):
        found = _with_knot(_room(found, p), step_variances(found, variance))
    return found


def shares(filters: Filters, num_levels: int, log_evidence: FloatArray | None = None) -> FloatArray:
    """Probability of each level of each bias, shape (p, L), by the latest evidence or another."""
    p = filters.step.shape[2]
    if num_levels == 1:
        return np.ones((p, 1))
    given = filters.evidence if log_evidence is None else log_evidence
    log_share = given[1:-1].reshape(p, num_levels)
    prior = np.append(0.5, np.full(num_levels - 1, 0.5 / (num_levels - 1)))
    odds = np.exp(log_share - log_share.max(axis=1, keepdims=True)) * prior
    return np.asarray(odds / odds.sum(axis=1, keepdims=True))


def step_variances(filters: Filters, variance: FloatArray) -> FloatArray:
    """Variances of the next step under each filter, (F, p): the mean of each bias, but its own."""
    L, p = variance.shape
    usual = np.einsum("pl,lp->p", shares(filters, L), variance)
    found = np.tile(usual, (len(filters.log_scale), 1))
    if L > 1:
        for c in range(p):
            found[1 + c * L : 1 + (c + 1) * L, c] = variance[:, c]
        past = np.vstack([filters.past, filters.evidence])
        then = past[len(past) - min(PAST, 1 + len(past) // 2)]
        found[-1] = np.einsum("pl,lp->p", shares(filters, L, then), variance)
    return found


def next_knot(filters: Filters, variance: FloatArray) -> Filters:
    """The oldest knot is integrated out and a new one is one step ahead."""
    p = filters.step.shape[2]
    step = step_variances(filters, variance) + _settling(filters, variance)
    return _with_knot(_without_oldest(filters, p), step)


def _settling(filters: Filters, variance: FloatArray) -> FloatArray:
    """More variance (F, p) in the step after one that was widened."""
    most = variance.max(axis=0) * (1.0 + 1e-9)
    beyond = np.maximum(filters.step[:, -1] - most, 0.0)
    return np.asarray(np.where(filters.step[:, -2] <= most, SETTLING * beyond, 0.0))


def _without_oldest(filters: Filters, p: int) -> Filters:
    precision, shift = filters.precision, filters.shift
    old, across = precision[:, :p, :p], precision[:, p:, :p]
    both = np.concatenate([np.swapaxes(across, 1, 2), shift[:, :p, None]], axis=2)
    solved = np.linalg.solve(old, both)
    rest = precision[:, p:, p:] - across @ solved[:, :, :-1]
    lead = solved[:, :, -1]
    gone = 0.5 * (np.einsum("fp,fp->f", shift[:, :p], lead) - np.linalg.slogdet(old)[1])
    room = _room(filters, p)
    room.precision[:, :-p, :-p] = 0.5 * (rest + np.swapaxes(rest, 1, 2))
    room.shift[:, :-p] = shift[:, p:] - np.einsum("fap,fp->fa", across, lead)
    return replace(room, log_scale=filters.log_scale + gone)


def _room(filters: Filters, p: int) -> Filters:
    """All moved by a knot, the oldest dropped."""
    precision, shift = np.zeros_like(filters.precision), np.zeros_like(filters.shift)
    precision[:, :-p, :-p] = filters.precision[:, p:, p:]
    shift[:, :-p] = filters.shift[:, p:]
    step = np.ones_like(filters.step)
    step[:, :-1] = filters.step[:, 1:]
    return replace(filters, precision=precision, shift=shift, step=step)


def _with_knot(filters: Filters, step: FloatArray) -> Filters:
    """The last knot, of which nothing is known, one step (F, p) from that before."""
    p = step.shape[1]
    precision = filters.precision.copy()
    _chain(precision, 1.0 / step, precision.shape[1] // p - 1)
    steps = filters.step.copy()
    steps[:, -1] = step
    log_scale = filters.log_scale - 0.5 * np.log(step).sum(axis=1)
    return replace(filters, precision=precision, log_scale=log_scale, step=steps)


def _chain(precision: FloatArray, weight: FloatArray, knot: int) -> None:
    """Add the density of the step to a knot, precision `weight` (F, p)."""
    p = weight.shape[1]
    new = knot * p + np.arange(p)
    precision[:, new, new] += weight
    precision[:, new - p, new - p] += weight
    precision[:, new, new - p] -= weight
    precision[:, new - p, new] -= weight


def widened(filters: Filters, knot: int, more: FloatArray) -> Filters:
    """With more variance (p,) in the step to a knot; evidence stays as it is."""
    before = filters.step[:, knot]
    after = before + more
    precision, step = filters.precision.copy(), filters.step.copy()
    _chain(precision, 1.0 / after - 1.0 / before, knot)
    step[:, knot] = after
    return replace(filters, precision=precision, step=step)


def moved(filters: Filters, away: FloatArray) -> Filters:
    """About biases that are larger by `away` (p,)."""
    all_knots = np.tile(away, filters.step.shape[1])
    pull = filters.precision @ all_knots
    gain = filters.shift @ all_knots - 0.5 * pull @ all_knots
    return replace(filters, shift=filters.shift - pull, log_scale=filters.log_scale + gain)


def weighed(filters: Filters, log_evidence: FloatArray) -> Filters:
    """With the evidence of one slice more."""
    past = np.vstack([filters.past, filters.evidence])[-PAST:]
    return replace(filters, evidence=log_evidence, past=past)


def as_before(filters: Filters, log_evidence: FloatArray, ago: int) -> Filters:
    """What slices of a step say of the walks is left out: evidence is that `ago` slices before.

    `log_evidence` is that of all reports as they are believed now.
    """
    past = np.vstack([filters.past, filters.evidence])
    then = past[max(0, len(past) - 1 - ago)]
    return weighed(replace(filters, log_scale=filters.log_scale + then - log_evidence), then)


def with_reports(filters: Filters, J: FloatArray, eta: FloatArray) -> Filters:
    """With what reports say of the knots."""
    return replace(filters, precision=filters.precision + J, shift=filters.shift + eta)


def belief(filters: Filters, J: FloatArray, eta: FloatArray, p: int) -> Belief:
    """The newest knot under each filter and reports of which J and eta are known."""
    F = len(filters.log_scale)
    found = Belief(np.empty((F, p)), np.empty((F, p)), np.empty(F))
    _newest(filters.precision, filters.shift, filters.log_scale, J, eta, found)
    return found


def whole_belief(
    filters: Filters, J: FloatArray, eta: FloatArray, which: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Mean (W p,) and covariance of all knots under one filter."""
    precision = filters.precision[which] + J
    scale = 1.0 / np.sqrt(np.diag(precision))
    covariance = np.linalg.inv(precision * np.outer(scale, scale)) * np.outer(scale, scale)
    covariance = 0.5 * (covariance + covariance.T)
    return covariance @ (filters.shift[which] + eta), covariance


def marginals(found: Belief, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and standard deviation (p,) of each bias over the levels of its walk."""
    p, L = share.shape
    if len(found.mean) == 1:
        return found.mean[0], np.sqrt(found.variance[0])
    own = np.arange(p)
    mean = found.mean[1:-1].reshape(p, L, p)[own, :, own]
    variance = found.variance[1:-1].reshape(p, L, p)[own, :, own]
    middle = (share * mean).sum(axis=1)
    spread = (share * (variance + (mean - middle[:, None]) ** 2)).sum(axis=1)
    return middle, np.sqrt(spread)


@numba.njit(cache=True)
def _newest(
    precision: FloatArray,
    shift: FloatArray,
    log_scale: FloatArray,
    J: FloatArray,
    eta: FloatArray,
    found: Belief,
) -> None:
    """Cholesky factors: the last rows are those of the newest knot alone."""
    C, p = len(eta), found.mean.shape[1]
    root, y = np.zeros((C, C)), np.empty(C)
    for f in range(len(log_scale)):
        evidence = log_scale[f]
        for a in range(C):
            for b in range(a + 1):
                value = precision[f, a, b] + J[a, b]
                for c in range(b):
                    value -= root[a, c] * root[b, c]
                root[a, b] = np.sqrt(value) if a == b else value / root[b, b]
            value = shift[f, a] + eta[a]
            for c in range(a):
                value -= root[a, c] * y[c]
            y[a] = value / root[a, a]
            evidence += 0.5 * y[a] * y[a] - np.log(root[a, a])
        found.log_evidence[f] = evidence
        inverse = np.linalg.inv(root[C - p :, C - p :].copy())
        for c in range(p):
            mean, variance = 0.0, 0.0
            for a in range(c, p):
                mean += inverse[a, c] * y[C - p + a]
                variance += inverse[a, c] * inverse[a, c]
            found.mean[f, c], found.variance[f, c] = mean, variance
