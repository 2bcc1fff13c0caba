"""Paths of targets given all their reports: mean, covariance, draws, answer to the biases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from probreg.errors import InvalidInputError
from probreg.motion.tracks._columns import smooth_columns
from probreg.motion.tracks._equations import TrackEquations, TrackMotion
from probreg.motion.tracks._simulate import observe_paths, simulate_paths
from probreg.motion.tracks._smoother import Smoothing, smooth_reports
from probreg.typing import FloatArray, IntArray
from probreg.validation import finite_array

_CHUNK = 50_000  # reports whose answer to the biases is held at once
_NONE = np.zeros(0)


@dataclass(frozen=True, eq=False)
class SmoothedTracks:
    """States of targets at their reports, given all reports and the biases.

    Attributes
    ----------
    mean : ndarray, shape (n, size)
        Position, velocity and the constants of the target.
    residual : ndarray, shape (E,)
        Of each equation.
    covariance : ndarray, shape (n, size, size), or (m, size, size) of those asked for, or None
    spread : ndarray, shape (E, width), or None
        h V h' of each equation with the equations of its report, in their order.
    """

    mean: FloatArray
    residual: FloatArray
    covariance: FloatArray | None = None
    spread: FloatArray | None = None


def smooth_tracks(
    equations: TrackEquations,
    motion: TrackMotion,
    weights: FloatArray | None = None,
    delta: FloatArray | None = None,
    *,
    covariance: bool | IntArray = False,
    spread: bool = False,
) -> SmoothedTracks:
    """Bryson-Frazier smoother of every target.

    Parameters
    ----------
    equations : TrackEquations
    motion : TrackMotion
    weights : ndarray, shape (n,) or (E,), optional
        Precision of each report, or equation, over the nominal one.
    delta : ndarray, shape (p,), optional
        Biases, by default zero.
    covariance : bool or ndarray of int, shape (m,)
        Whether it is wanted, or of which reports, each named once.
    spread : bool
        Whether it is wanted.

    References
    ----------
    Bryson and Frazier (1963); Durbin and Koopman, "Time Series Analysis by State Space Methods"
    (2012), section 4.4.
    """
    y = equations.y if delta is None else equations.minus_biases(delta)
    n, E, size = len(equations.time), len(y), motion.start_mean.shape[1]
    width = int(np.diff(equations.report_start).max(initial=0))
    which, count = _places(covariance, n)
    out = Smoothing(
        np.empty((n, size)),
        which,
        np.empty((count, size, size)),
        np.empty(E),
        np.zeros((E if spread else 0, width)),
    )
    smooth_reports(equations.shape, equations, motion, equations.precision(weights), y, out)
    return SmoothedTracks(
        out.mean,
        out.residual,
        None if covariance is False else out.covariance,
        out.spread if spread else None,
    )


def _places(asked: bool | IntArray, n: int) -> tuple[IntArray, int]:
    """Where the covariance of each report goes, and how many are asked for."""
    rows = np.arange(n if asked else 0) if isinstance(asked, bool) else np.asarray(asked)
    which = np.full(n if len(rows) else 0, -1)
    which[rows] = np.arange(len(rows))
    return which, len(rows)


def draw_tracks(
    equations: TrackEquations,
    motion: TrackMotion,
    rng: np.random.Generator,
    weights: FloatArray | None = None,
    delta: FloatArray | None = None,
) -> SmoothedTracks:
    """One draw of every path given all reports: the simulation smoother.

    Returns
    -------
    SmoothedTracks
        The drawn states as mean, and the residuals against them.

    References
    ----------
    Durbin and Koopman, Biometrika 89 (2002).
    """
    precision = equations.precision(weights)
    states, observed = draw_model(equations, motion, rng)
    noise = np.zeros(len(observed))
    there = precision > 0.0
    noise[there] = rng.standard_normal(int(there.sum())) / np.sqrt(precision[there])
    y = equations.y if delta is None else equations.minus_biases(delta)
    n, size = states.shape
    none = np.zeros(0, dtype=np.int64), np.zeros((0, size, size))
    out = Smoothing(np.empty((n, size)), *none, np.empty(len(y)), np.zeros((0, 0)))
    smooth_reports(equations.shape, equations, motion, precision, y - observed - noise, out)
    return SmoothedTracks(states + out.mean, out.residual + noise)


def draw_model(
    equations: TrackEquations, motion: TrackMotion, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Paths (n, size) about zero as targets move, and their noise-free equations (E,)."""
    K, size = motion.start_mean.shape
    n = len(equations.time)
    states, observed = np.empty((n, size)), np.empty(len(equations.y))
    z_start = rng.standard_normal((K, size))
    z_step = rng.standard_normal((n, 2, equations.dim))
    simulate_paths(equations, motion, z_start, z_step, states)
    observe_paths(equations.shape, equations, states, observed)
    return states, observed


def bias_response(
    equations: TrackEquations,
    motion: TrackMotion,
    num_biases: int,
    weights: FloatArray | None = None,
    targets: tuple[int, int] | None = None,
) -> FloatArray:
    """What smoothed states lose for each unit of bias, shape (reports, size, p).

    Of the targets from the first to before the last of `targets`, by default all.
    """
    first, last = (0, len(motion.q)) if targets is None else targets
    count = equations.target_start[last] - equations.target_start[first]
    states = np.zeros((int(count), motion.start_mean.shape[1], num_biases))
    smooth_columns(equations.shape, equations, motion, equations.precision(weights), first, states)
    return states


def add_bias_uncertainty(
    covariance: FloatArray,
    equations: TrackEquations,
    motion: TrackMotion,
    bias_covariance: FloatArray,
    weights: FloatArray | None = None,
) -> FloatArray:
    """Covariance of smoothed states (n, size, size) with that of the biases, V + M Sigma M'.

    `bias_covariance` is (p, p), or (n, p, p) where it is another at each report.
    """
    total = covariance.copy()
    start = equations.target_start
    K, first = len(start) - 1, 0
    while first < K:
        last = int(np.searchsorted(start, start[first] + _CHUNK, side="right")) - 1
        last = min(max(last, first + 1), K)
        p = bias_covariance.shape[-1]
        M = bias_response(equations, motion, p, weights, (first, last))
        rows = slice(start[first], start[last])
        if bias_covariance.ndim == 3:
            total[rows] += M @ bias_covariance[rows] @ np.swapaxes(M, 1, 2)
        else:
            total[rows] += np.einsum("nac,cd,nbd->nab", M, bias_covariance, M, optimize=True)
        first = last
    return total


def with_times(
    equations: TrackEquations, target: IntArray, time: FloatArray
) -> tuple[TrackEquations, IntArray]:
    """Equations with reports of no content at other times, for states between reports.

    Parameters
    ----------
    equations : TrackEquations
    target : ndarray of int, shape (m,)
    time : ndarray, shape (m,)
        Seconds, not before the first report of the target.

    Returns
    -------
    equations : TrackEquations
    rows : ndarray of int, shape (m,)
        Which of its reports stand at these times.

    Raises
    ------
    InvalidInputError
        A target that is not there; a time before its first report, where its path starts.
    """
    whom = np.asarray(target)
    when = finite_array("time", time, (len(whom),))
    first, K = equations.target_start, len(equations.target_start) - 1
    if whom.size and not (whom.dtype.kind in "iu" and 0 <= whom.min() <= whom.max() < K):
        raise InvalidInputError(f"targets count from 0 to {K - 1}.")
    if (np.diff(first)[whom] == 0).any() or (when < equations.time[first[whom]]).any():
        raise InvalidInputError("a time is before the first report of its target.")
    n = len(equations.time)
    both = np.concatenate([equations.time, when])
    order = np.lexsort([both, np.concatenate([equations.target, whom])])
    counts = np.concatenate([np.diff(equations.report_start), np.zeros(len(when), dtype=int)])
    sizes = np.diff(first) + np.bincount(whom, minlength=K)
    push = equations.push
    if len(push):
        # a gap that is cut keeps its acceleration; beyond the last report the last one holds
        real_before: IntArray = np.cumsum(order < n) - (order < n)
        owner = np.repeat(np.arange(K), sizes)
        push = push[np.minimum(real_before, first[owner + 1] - 1)]
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    extended = equations._replace(
        target_start=np.concatenate([[0], np.cumsum(sizes)]),
        report_start=np.concatenate([[0], np.cumsum(counts[order])]),
        time=both[order],
        push=np.ascontiguousarray(push),
    )
    return extended, place[n:]
