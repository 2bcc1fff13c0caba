"""Compiled smoother of the bias columns: how smoothed states answer to the biases."""

from __future__ import annotations

import numba
import numpy as np

from probreg.motion.tracks._equations import Shape, TrackEquations, TrackMotion
from probreg.motion.tracks._filter import FAST, answer
from probreg.motion.tracks._smoother import Memory, forward, memory_of
from probreg.typing import FloatArray


@numba.njit(cache=True, fastmath=FAST)
def smooth_columns(
    shape: Shape,
    equations: TrackEquations,
    motion: TrackMotion,
    precision: FloatArray,
    first_target: int,
    states: FloatArray,
) -> None:
    """Write what smoothed states lose for each unit of bias into states (reports, size, p).

    Of the targets from `first_target` on, as many as `states` has room for.
    """
    p = states.shape[2]
    memory = memory_of(equations)
    n = np.empty((memory.nu.size, p))
    start, k = equations.target_start[first_target], first_target
    while k < len(motion.q) and equations.target_start[k + 1] - start <= len(states):
        low, high = equations.target_start[k], equations.target_start[k + 1]
        own = states[low - start : high - start]
        forward(shape, equations, motion, precision, equations.y, k, memory)
        _forth(shape, equations, k, memory, n, own)
        _back(equations, k, memory, n, own)
        k += 1


@numba.njit(cache=True, fastmath=FAST)
def _forth(
    shape: Shape,
    equations: TrackEquations,
    k: int,
    memory: Memory,
    n: FloatArray,
    states: FloatArray,
) -> None:
    """Filter the columns: n of each equation, and M after each report."""
    d, size, p = equations.push.shape[1], states.shape[1], states.shape[2]
    low, high = equations.target_start[k], equations.target_start[k + 1]
    base = equations.report_start[low]
    M = np.zeros((size, p))
    for i in range(low, high):
        dt = equations.time[i] - equations.time[i - 1] if i > low else 0.0
        for a in range(d):
            for c in range(p):
                M[a, c] += dt * M[d + a, c]
        for e in range(equations.report_start[i], equations.report_start[i + 1]):
            phi = memory.phi[e - base]
            if phi == 0.0:
                continue
            own = n[e - base]
            answer(shape, equations, e, M, own)
            for a in range(size):
                for c in range(p):
                    M[a, c] += memory.g[e - base, a] / phi * own[c]
        states[i - low] = M


@numba.njit(cache=True, fastmath=FAST)
def _back(
    equations: TrackEquations, k: int, memory: Memory, n: FloatArray, states: FloatArray
) -> None:
    """Bring in what later reports say."""
    d, size, p = equations.push.shape[1], states.shape[1], states.shape[2]
    low, high = equations.target_start[k], equations.target_start[k + 1]
    base = equations.report_start[low]
    R, lead = np.zeros((size, p)), np.empty(p)
    for i in range(high - 1, low - 1, -1):
        if i + 1 < high and equations.time[i + 1] == equations.time[i]:
            states[i - low] = states[i + 1 - low]
        else:
            for a in range(size):
                for b in range(size):
                    for c in range(p):
                        states[i - low, a, c] += memory.P[i - low, a, b] * R[b, c]
        for e in range(equations.report_start[i + 1] - 1, equations.report_start[i] - 1, -1):
            phi = memory.phi[e - base]
            if phi == 0.0:
                continue
            lead[:] = n[e - base]
            for a in range(size):
                for c in range(p):
                    lead[c] -= memory.g[e - base, a] * R[a, c]
            for b in range(equations.h.shape[1]):
                row = R[b if b < d else b + d]
                for c in range(p):
                    row[c] += equations.h[e, b] * lead[c] / phi
        dt = equations.time[i] - equations.time[i - 1] if i > low else 0.0
        for a in range(d):
            for c in range(p):
                R[d + a, c] += dt * R[a, c]
