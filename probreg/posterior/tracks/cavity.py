"""Compiled leave-one-out densities of reports, and what they say of precision and identity."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from probreg.motion.tracks import TrackEquations
from probreg.typing import BoolArray, FloatArray, IntArray

_LOG_2PI = float(np.log(2.0 * np.pi))


class ReportMixtures(NamedTuple):
    """Gaussians of each sensor's noise, padded to a common number.

    Attributes
    ----------
    sensor : ndarray of int, shape (n,)
    log_share : ndarray, shape (sensors, J)
        Minus infinity in padding.
    variance : ndarray, shape (sensors, J)
    log_wrong : ndarray, shape (n,)
        Log density of a report of another target, with the share of such reports; minus
        infinity if there are none.
    """

    sensor: IntArray
    log_share: FloatArray
    variance: FloatArray
    log_wrong: FloatArray


class Judgement(NamedTuple):
    """What reports are, given all others.

    Attributes
    ----------
    probability : ndarray, shape (n, J)
        Of each Gaussian of the sensor's law; with that of a wrong identity they add up to one.
    wrong : ndarray, shape (n,)
    square : ndarray, shape (n, J)
        Expected squared noise, in nominal variances, if the report is of that Gaussian.
    log_density : ndarray, shape (n,)
        Of the report given all others: the leave-one-out score.
    weight : ndarray, shape (n,)
        Expected precision over the nominal one; that of a wrong identity is zero.
    placed : ndarray of bool, shape (n,)
        Whether the others place the report within `widest`.
    """

    probability: FloatArray
    wrong: FloatArray
    square: FloatArray
    log_density: FloatArray
    weight: FloatArray
    placed: BoolArray


def room_for(n: int, J: int) -> Judgement:
    """Arrays to write into."""
    square, probability = np.zeros((n, J)), np.zeros((n, J))
    wrong, log_density, weight = np.zeros(n), np.zeros(n), np.zeros(n)
    return Judgement(probability, wrong, square, log_density, weight, np.zeros(n, dtype=bool))


@numba.njit(cache=True)
def solve_in_place(A: FloatArray, B: FloatArray, m: int) -> None:
    """Solve A X = B by elimination with pivots; both are overwritten, B by X."""
    for k in range(m):
        pivot = k
        for i in range(k + 1, m):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(m):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
            for j in range(B.shape[1]):
                B[k, j], B[pivot, j] = B[pivot, j], B[k, j]
        for i in range(k + 1, m):
            factor = A[i, k] / A[k, k]
            for j in range(k, m):
                A[i, j] -= factor * A[k, j]
            for j in range(B.shape[1]):
                B[i, j] -= factor * B[k, j]
    for k in range(m - 1, -1, -1):
        for j in range(B.shape[1]):
            for i in range(k + 1, m):
                B[k, j] -= A[k, i] * B[i, j]
            B[k, j] /= A[k, k]


@numba.njit(cache=True)
def invert(C: FloatArray, inverse: FloatArray, m: int) -> float:
    """Write the inverse of a positive definite C, which is lost; returns log |C|."""
    log_det = 0.0
    for j in range(m):
        for i in range(m):
            inverse[i, j] = 1.0 if i == j else 0.0
    # Gauss-Jordan without pivots, safe for positive definite matrices
    for k in range(m):
        head = C[k, k]
        log_det += np.log(head)
        for j in range(m):
            C[k, j] /= head
            inverse[k, j] /= head
        for i in range(m):
            if i != k:
                factor = C[i, k]
                for j in range(m):
                    C[i, j] -= factor * C[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
    return log_det


class _Room(NamedTuple):
    """Small arrays to work in: I - A W; A and a; a covariance and its inverse; log odds."""

    B: FloatArray
    X: FloatArray
    C: FloatArray
    inverse: FloatArray
    log_p: FloatArray


@numba.njit(cache=True)
def judge_reports(
    equations: TrackEquations,
    residual: FloatArray,
    spread: FloatArray,
    precision: FloatArray,
    mixtures: ReportMixtures,
    widest: float,
    out: Judgement,
) -> None:
    """Write into `out` what each report is, given all others.

    With residual a and A = h V h' under all reports, those without report i are
    A_c = (I - A W)^-1 A and a_c = (I - A W)^-1 a, W its precision.
    """
    w, J = spread.shape[1], mixtures.variance.shape[1]
    room = _Room(
        np.empty((w, w)), np.empty((w, w + 1)), np.empty((w, w)), np.empty((w, w)), np.empty(J)
    )
    B, X = room.B, room.X
    for i in range(len(equations.time)):
        first = equations.report_start[i]
        m = equations.report_start[i + 1] - first
        for a in range(m):
            for b in range(m):
                B[a, b] = (1.0 if a == b else 0.0) - spread[first + a, b] * precision[first + b]
                X[a, b] = spread[first + a, b]
            X[a, w] = residual[first + a]
        solve_in_place(B, X, m)
        sound = m > 0
        out.placed[i] = m > 0
        for a in range(m):
            sound &= X[a, a] >= 0.0
            out.placed[i] &= X[a, a] < widest * widest
        if not sound:
            # rounding has eaten a covariance: nothing is known of the report but its noise
            out.placed[i] = False
            for a in range(m):
                X[a, :m] = 0.0
                X[a, a] = widest * widest
        _weigh(equations.variance[first : first + m], mixtures, room, i, out)


@numba.njit(cache=True)
def _weigh(
    variance: FloatArray, mixtures: ReportMixtures, room: _Room, i: int, out: Judgement
) -> None:
    """Write the odds of report i to be of each Gaussian and of none, given `room.X`."""
    m, w, group = len(variance), room.C.shape[0], mixtures.sensor[i]
    X, C, inverse, log_p = room.X, room.C, room.inverse, room.log_p
    top = mixtures.log_wrong[i]
    for j in range(len(log_p)):
        log_p[j] = mixtures.log_share[group, j]
        if log_p[j] > -np.inf:
            grown = mixtures.variance[group, j]
            for a in range(m):
                for b in range(m):
                    C[a, b] = 0.5 * (X[a, b] + X[b, a])
                C[a, a] += grown * variance[a]
            log_p[j] -= 0.5 * (m * _LOG_2PI + invert(C, inverse, m))
            out.square[i, j] = 0.0
            for a in range(m):
                lead = 0.0
                for b in range(m):
                    lead += inverse[a, b] * X[b, w]
                log_p[j] -= 0.5 * lead * X[a, w]
                gain = grown * grown * variance[a]
                out.square[i, j] += gain * (lead * lead - inverse[a, a]) + grown
        top = max(top, log_p[j])
    out.wrong[i] = np.exp(mixtures.log_wrong[i] - top)
    total = out.wrong[i]
    for j in range(len(log_p)):
        log_p[j] = np.exp(log_p[j] - top)
        total += log_p[j]
    out.weight[i] = 0.0
    for j in range(len(log_p)):
        out.probability[i, j] = log_p[j] / total
        out.weight[i] += out.probability[i, j] / mixtures.variance[group, j]
    out.wrong[i] /= total
    out.log_density[i] = top + np.log(total)
