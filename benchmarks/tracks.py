"""Seconds of the track engine: elimination, smoothing and a draw of a million reports.

Run by `make benchmark`. Two equations a report, tracks of 200 reports, one thread. Nothing is
asserted.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from probreg.motion.tracks import (
    ScalarEquations,
    TrackEquations,
    TrackMotion,
    draw_tracks,
    eliminate_paths,
    smooth_tracks,
    track_equations,
    track_motion,
)

REPORTS, EACH, EQUATIONS = 1_000_000, 200, 2
SHAPES = ((2, 0, 6), (2, 0, 20), (3, 0, 6), (3, 0, 20), (3, 1, 6), (3, 1, 20))


def scene(d: int, c: int, p: int) -> tuple[TrackEquations, TrackMotion]:
    """Random directions, as many biases an equation as three sensors would have."""
    rng = np.random.default_rng(0)
    K, E = REPORTS // EACH, REPORTS * EQUATIONS
    h = rng.standard_normal((E, d))
    sensor = rng.integers(0, 3, E)
    own = -(-p // 6)
    column = (2 * sensor + np.arange(E) % 2)[:, None] + 6 * np.arange(own)
    equations = track_equations(
        EACH * np.arange(K + 1),
        EQUATIONS * np.arange(REPORTS + 1),
        np.sort(rng.uniform(0.0, 1200.0, (K, EACH)), axis=1).ravel(),
        ScalarEquations(
            50.0 * rng.standard_normal(E),
            h / np.linalg.norm(h, axis=1)[:, None],
            np.full(E, 2500.0),
            np.ones((E, c)),
            column % p,
            rng.uniform(0.5, 1.5, (E, own)),
        ),
    )
    sd = np.repeat([1e5, 350.0, 30.0], [d, d, c])
    return equations, track_motion(equations, 1.0, np.zeros(2 * d + c), sd)


def best(run: Callable[[], object], times: int = 3) -> float:
    """Least seconds of several calls, after one that compiles."""
    run()
    spent = []
    for _ in range(times):
        begin = time.perf_counter()
        run()
        spent.append(time.perf_counter() - begin)
    return min(spent)


def main() -> None:
    """Print a line for each shape."""
    print(f"{'d, constants, biases':<24}{'eliminate (s)':>14}{'smooth (s)':>12}{'draw (s)':>10}")
    rng = np.random.default_rng(1)
    for d, c, p in SHAPES:
        equations, motion = scene(d, c, p)
        spent = [
            best(lambda e=equations, m=motion, p=p: eliminate_paths(e, m, p)),
            best(lambda e=equations, m=motion: smooth_tracks(e, m, spread=True)),
            best(lambda e=equations, m=motion: draw_tracks(e, m, rng), 1),
        ]
        print(f"{f'{d}, {c}, {p}':<24}{spent[0]:>14.2f}{spent[1]:>12.2f}{spent[2]:>10.2f}")


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
