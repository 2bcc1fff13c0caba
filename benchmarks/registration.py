"""Seconds and memory of registering recordings of growing size, step by step.

Run by `make benchmark`. Three radars at their own times, a fifth of the pairs wrong, one report in
twenty with ten times the noise; one thread, and a process of its own for each size, so that the
peak is of that size (the simulated recording is in it). The ratio is to the time of the shortest
recording. Nothing is asserted.
"""

from __future__ import annotations

import multiprocessing
import resource
import time
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from probreg.registration import register
from probreg.scenarios.traffic import TrafficScene, simulate

SIZES = (1_000, 5_000, 10_000, 100_000, 1_000_000)


class Measured(NamedTuple):
    """One recording: seconds, gigabytes, and the seconds of every step."""

    tracks: int
    seconds: float
    peak_gb: float
    steps: dict[str, float]


def measure(reports: int) -> Measured:
    """Register one recording, after a short one that compiles."""
    with threadpool_limits(1):
        rng = np.random.default_rng(0)
        recording, setup, _ = simulate(TrafficScene(reports=500), rng)
        register(recording, setup, rng=rng)
        scene = TrafficScene(reports=reports, wrong_share=0.2, outlier_share=0.05)
        recording, setup, _ = simulate(scene, np.random.default_rng(reports))
        begin = time.perf_counter()
        found = register(recording, setup, rng=np.random.default_rng(1))
        spent = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    return Measured(len(found.problem.owner), spent, peak, dict(found.seconds))


def main() -> None:
    """Print one line a size, with the three dearest steps."""
    print(f"{'reports':>10}{'tracks':>9}{'seconds':>9}{'ratio':>8}{'peak (GB)':>11}  dearest steps")
    fresh = multiprocessing.get_context("spawn")
    first = 0.0
    with ProcessPoolExecutor(1, mp_context=fresh, max_tasks_per_child=1) as pool:
        for reports in SIZES:
            one = pool.submit(measure, reports).result()
            first = first or one.seconds
            steps = sorted(one.steps.items(), key=lambda item: -item[1])[:3]
            dear = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in steps)
            size = f"{reports:>10}{one.tracks:>9}{one.seconds:>9.1f}{one.seconds / first:>8.1f}"
            print(f"{size}{one.peak_gb:>11.2f}  {dear}", flush=True)


if __name__ == "__main__":
    main()
