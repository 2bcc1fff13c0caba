"""Tracks as one dense Gaussian vector: the integrated Wiener process, written out.

Shares nothing with the filter: covariances of the process in closed form, generalised least
squares, conditioning.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from probreg.motion.tracks import ScalarEquations, track_equations, track_motion


class Tracks(NamedTuple):
    equations: object
    motion: object
    num_biases: int
    weights: np.ndarray


def random_tracks(seed, d=2, c=0, p=4, start_sd=(3e3, 80.0, 40.0), push=False, targets=4):
    """Small tracks with equal times, reports of no, one or several equations, and weights.

    Some weights are zero or as good as zero.
    """
    rng = np.random.default_rng(seed)
    lengths = rng.integers(1, 9, targets)
    n = int(lengths.sum())
    time = np.concatenate([np.sort(rng.uniform(100.0, 160.0, m)) for m in lengths])
    first = np.concatenate([[0], np.cumsum(lengths)])
    for k in range(targets):
        if lengths[k] > 3:
            time[first[k] + 2] = time[first[k] + 1]
    counts = rng.integers(0, 4, n)
    E = int(counts.sum())
    h = rng.normal(size=(E, d + c))
    h[:, :d] /= np.linalg.norm(h[:, :d], axis=1)[:, None]
    equations = track_equations(
        first,
        np.concatenate([[0], np.cumsum(counts)]),
        time,
        ScalarEquations(
            rng.normal(0.0, 100.0, E),
            h[:, :d],
            rng.uniform(20.0, 80.0, E) ** 2,
            h[:, d:],
            rng.integers(0, p, (E, 2)),
            rng.normal(size=(E, 2)),
        ),
        rng.normal(0.0, 3.0, (n, d)) if push else None,
    )
    sd = np.repeat(start_sd, [d, d, c])
    mean = rng.normal(size=(targets, 2 * d + c)) * np.repeat([100.0, 5.0, 3.0], [d, d, c])
    motion = track_motion(equations, rng.uniform(0.2, 4.0, targets), mean, sd)
    weights = rng.uniform(0.1, 2.0, n)
    weights[rng.random(n) < 0.15] = 0.0
    weights[rng.random(n) < 0.1] = 1e-9
    return Tracks(equations, motion, p, weights)


def process_covariance(time, q, with_process=True):
    """Covariances (position, position), (position, velocity), (velocity, velocity) at times.

    Of the integrated Wiener process from zero at zero, each (n, n).
    """
    s, t = np.meshgrid(time, time, indexing="ij")
    low, high = np.minimum(s, t), np.maximum(s, t)
    scale = q if with_process else 0.0
    pp = scale * low**2 * (3.0 * high - low) / 6.0
    pv = scale * np.where(s <= t, s**2 / 2.0, s * t - t**2 / 2.0)
    return pp, pv, scale * low


def prior_of(tracks, k, with_process=True):
    """Mean (n size,) and covariance of all states of target k before any report."""
    equations, motion, *_ = tracks
    d, size = equations.dim, motion.start_mean.shape[1]
    rows = slice(equations.target_start[k], equations.target_start[k + 1])
    time = equations.time[rows] - equations.time[rows][0]
    n = len(time)
    pp, pv, vv = process_covariance(time, motion.q[k], with_process)
    variance = motion.start_variance[k]
    full = np.zeros((n, size, n, size))
    for a in range(d):
        p, v = a, d + a
        full[:, p, :, p] = pp + variance[p] + np.outer(time, time) * variance[v]
        full[:, p, :, v] = pv + time[:, None] * variance[v]
        full[:, v, :, p] = full[:, p, :, v].T
        full[:, v, :, v] = vv + variance[v]
    for a in range(2 * d, size):
        full[:, a, :, a] = variance[a]
    mean = np.tile(motion.start_mean[k], (n, 1))
    mean[:, :d] += time[:, None] * motion.start_mean[k, d : 2 * d]
    if len(equations.push):
        push = equations.push[rows]
        for i in range(n):
            for j in range(1, i + 1):
                gap, after = time[j] - time[j - 1], time[i] - time[j]
                mean[i, d : 2 * d] += push[j] * gap
                mean[i, :d] += push[j] * (0.5 * gap**2 + gap * after)
    return mean.ravel(), full.reshape(n * size, n * size)


class Posterior(NamedTuple):
    J: np.ndarray
    eta: np.ndarray
    ll: float
    mean: np.ndarray
    covariance: np.ndarray
    response: np.ndarray


def dense_posterior(tracks, k, delta=None, with_process=True):
    """Information about the biases and states given everything, of target k."""
    equations, motion, p, weights = tracks
    size, d = motion.start_mean.shape[1], equations.dim
    prior_mean, prior = prior_of(tracks, k, with_process)
    reports = range(equations.target_start[k], equations.target_start[k + 1])
    H, S, y, noise = [], [], [], []
    for at, i in enumerate(reports):
        for e in range(equations.report_start[i], equations.report_start[i + 1]):
            if weights[i] < 1e-6:
                continue
            row = np.zeros(len(prior_mean))
            row[at * size : at * size + d] = equations.h[e, :d]
            row[at * size + 2 * d : (at + 1) * size] = equations.h[e, d:]
            own = np.zeros(p)
            np.add.at(own, equations.column[e], equations.response[e])
            H.append(row)
            S.append(own)
            y.append(equations.y[e])
            noise.append(equations.variance[e] / weights[i])
    n = len(list(reports))
    if not y:
        zero = np.zeros((p, p)), np.zeros(p), 0.0
        shape = (n, size, n, size)
        return Posterior(
            *zero, prior_mean.reshape(n, size), prior.reshape(shape), np.zeros((n, size, p))
        )
    H, S, y = np.array(H), np.array(S), np.array(y)
    C = H @ prior @ H.T + np.diag(noise)
    e = y - H @ prior_mean
    inverse = np.linalg.inv(C)
    ll = -0.5 * (len(y) * np.log(2 * np.pi) + np.linalg.slogdet(C)[1] + e @ inverse @ e)
    gain = prior @ H.T @ inverse
    left = e if delta is None else e - S @ delta
    return Posterior(
        S.T @ inverse @ S,
        S.T @ inverse @ e,
        ll,
        (prior_mean + gain @ left).reshape(n, size),
        (prior - gain @ H @ prior).reshape(n, size, n, size),
        (gain @ S).reshape(n, size, p),
    )
