"""Compiled draws of paths and reports from the model itself."""

from __future__ import annotations

import numba
import numpy as np

from probreg.motion.tracks._equations import Shape, TrackEquations, TrackMotion
from probreg.motion.tracks._filter import project
from probreg.typing import FloatArray


@numba.njit(cache=True)
def simulate_paths(
    equations: TrackEquations,
    motion: TrackMotion,
    z_start: FloatArray,
    z_step: FloatArray,
    states: FloatArray,
) -> None:
    """Write paths about zero into states (n, size).

    Of standard normal numbers z_start (K, size) and z_step (n, 2, d); without start mean and
    push.
    """
    d, size = equations.push.shape[1], states.shape[1]
    for k in range(len(motion.q)):
        low, high = equations.target_start[k], equations.target_start[k + 1]
        for i in range(low, high):
            if i == low:
                for a in range(size):
                    states[i, a] = np.sqrt(motion.start_variance[k, a]) * z_start[k, a]
                continue
            dt = equations.time[i] - equations.time[i - 1]
            root = np.sqrt(motion.q[k] * dt)
            states[i] = states[i - 1]
            for a in range(d):
                # Cholesky root of [dt^3 / 3, dt^2 / 2; dt^2 / 2, dt]
                first, second = root * z_step[i, 0, a], root * z_step[i, 1, a]
                states[i, a] += dt * (states[i - 1, d + a] + first / np.sqrt(3.0))
                states[i, d + a] += np.sqrt(3.0) / 2.0 * first + 0.5 * second


@numba.njit(cache=True)
def observe_paths(
    shape: Shape, equations: TrackEquations, states: FloatArray, y: FloatArray
) -> None:
    """Write h . (position, constants) of each equation into y (E,)."""
    for i in range(len(states)):
        for e in range(equations.report_start[i], equations.report_start[i + 1]):
            y[e] = project(shape, equations.h[e], states[i])
