"""Compiled leave-one-out densities of reports, and what they say of precision and identity."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from probreg.motion.tracks import TrackEquations
from probreg.typing import BoolArray, FloatArray, IntArray

FAST = {"contract", "reassoc", "nsz", "arcp"}  # NaN and infinity keep their meaning
MOST_SWEEPS, EXACT = 12, 1e-28  # of Jacobi; squared correlation that is none


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


# rows of a small array to work in: of the components, in units of the noise
SCALE, ALONG, SPREAD = 0, 1, 2  # 1 / sigma; residual and variance along eigenvectors


@numba.njit(cache=True, fastmath=FAST, inline="always")
def diagonalise(A: FloatArray, Q: FloatArray, m: int) -> None:
    """Jacobi's rotations: the symmetric A (m, m) becomes diagonal, Q its eigenvectors."""
    for a in range(m):
        for b in range(m):
            Q[a, b] = 1.0 if a == b else 0.0
    for _ in range(MOST_SWEEPS):
        moved = False
        for a in range(m):
            for b in range(a):
                if A[a, b] * A[a, b] <= EXACT * abs(A[a, a] * A[b, b]):
                    continue
                moved = True
                away = 0.5 * (A[b, b] - A[a, a]) / A[a, b]
                tangent = 1.0 / (abs(away) + np.sqrt(away * away + 1.0))
                if away < 0.0:
                    tangent = -tangent
                c = 1.0 / np.sqrt(tangent * tangent + 1.0)
                s = tangent * c
                for k in range(m):
                    A[k, a], A[k, b] = c * A[k, a] - s * A[k, b], s * A[k, a] + c * A[k, b]
                    Q[k, a], Q[k, b] = c * Q[k, a] - s * Q[k, b], s * Q[k, a] + c * Q[k, b]
                for k in range(m):
                    A[a, k], A[b, k] = c * A[a, k] - s * A[b, k], s * A[a, k] + c * A[b, k]
        if not moved or m == 2:
            break


@numba.njit(cache=True, fastmath=FAST)
def judge_reports(
    equations: TrackEquations,
    smoothed: tuple[FloatArray, FloatArray],
    weights: FloatArray,
    mixtures: ReportMixtures,
    widest: float,
    out: Judgement,
) -> None:
    """Write into `out` what each report is, given all others.

    `smoothed` are residuals (E,) a and h V h' (E, width) A under all reports, of weights (n,).
    In units of the noise, those without report i are A_c = (I - w A)^-1 A and
    a_c = (I - w A)^-1 a: the same eigenvectors, so that all the rest are scalars.
    """
    # arrays are taken out of their tuples once: each time costs as much as an equation
    residual, spread = smoothed
    start, variance = equations.report_start, equations.variance
    sensor, log_share, parts = mixtures.sensor, mixtures.log_share, mixtures.variance
    probability, wrong, square = out.probability, out.wrong, out.square
    width, J = spread.shape[1], parts.shape[1]
    A, Q, room, log_p = (
        np.empty((width, width)),
        np.empty((width, width)),
        np.empty((3, width)),
        np.empty(J),
    )
    for i in range(len(weights)):
        first, m, group = start[i], start[i + 1] - start[i], sensor[i]
        own = residual[first : first + m], spread[first : first + m], variance[first : first + m]
        size, out.placed[i] = _leave_out(own, weights[i], widest, A, Q, room)
        top = mixtures.log_wrong[i]
        for j in range(J):
            log_p[j] = log_share[group, j]
            if log_p[j] > -np.inf:
                square[i, j], misfit = _misfit(m, room, size, parts[group, j])
                log_p[j] -= misfit
            top = max(top, log_p[j])
        wrong[i] = np.exp(mixtures.log_wrong[i] - top)
        total = wrong[i]
        for j in range(J):
            log_p[j] = np.exp(log_p[j] - top)
            total += log_p[j]
        weight, share = 0.0, 1.0 / total
        for j in range(J):
            probability[i, j] = log_p[j] * share
            weight += probability[i, j] / parts[group, j]
        out.weight[i] = weight
        wrong[i] *= share
        out.log_density[i] = top + np.log(total)


@numba.njit(cache=True, fastmath=FAST, inline="always")
def _leave_out(
    own: tuple[FloatArray, FloatArray, FloatArray],
    weight: float,
    widest: float,
    A: FloatArray,
    Q: FloatArray,
    room: FloatArray,
) -> tuple[float, bool]:
    """Write A_c and a_c along eigenvectors.

    Returns the determinant of 2 pi times the noise, and whether others place the report.
    """
    residual, spread, variance = own
    m, size = len(residual), 1.0
    for a in range(m):
        size *= 2.0 * np.pi * variance[a]
        room[SCALE, a] = 1.0 / np.sqrt(variance[a])
        for b in range(a + 1):
            both = 0.5 * (spread[a, b] + spread[b, a])
            A[a, b] = A[b, a] = both * room[SCALE, a] * room[SCALE, b]
    diagonalise(A, Q, m)
    sound = m > 0
    for k in range(m):
        left, along = 1.0 - weight * A[k, k], 0.0
        sound &= left > 0.0
        for a in range(m):
            along += Q[a, k] * residual[a] * room[SCALE, a]
        room[ALONG, k] = along / left
        room[SPREAD, k] = max(A[k, k], 0.0) / left
    placed = sound
    for a in range(m):
        wide = 0.0
        for k in range(m):
            wide += Q[a, k] * Q[a, k] * room[SPREAD, k]
        placed &= wide * variance[a] < widest * widest
        if not sound:
            # rounding has eaten a covariance: nothing is known of the report but its noise
            room[SPREAD, a] = (widest * room[SCALE, a]) ** 2
            room[ALONG, a] = residual[a] * room[SCALE, a]
    return size, placed


@numba.njit(cache=True, fastmath=FAST, inline="always")
def _misfit(m: int, room: FloatArray, size: float, grown: float) -> tuple[float, float]:
    """Expected squared noise, and minus the log density, of a Gaussian of variance `grown`."""
    determinant, misfit, square = size, 0.0, m * grown
    for k in range(m):
        inverse = 1.0 / (room[SPREAD, k] + grown)
        lead = room[ALONG, k] * inverse
        determinant *= room[SPREAD, k] + grown
        misfit += lead * room[ALONG, k]
        square += grown * grown * (lead * lead - inverse)
    return square, 0.5 * (np.log(determinant) + misfit)
