"""Seconds and memory of registering recordings of growing size, step by step.

Run by `make benchmark`. Three radars at their own times, a fifth of the pairs wrong, one report in
twenty with ten times the noise. The ratio is to the time of the shortest recording. Nothing is
asserted.
"""

from __future__ import annotations

import resource
import time

import numpy as np
from threadpoolctl import threadpool_limits

from probreg.registration import register
from probreg.scenarios.traffic import TrafficScene, simulate

SIZES = (1_000, 10_000, 100_000, 1_000_000)


def main() -> None:
    """Print one line a size, with the two dearest steps."""
    rng = np.random.default_rng(0)
    recording, setup, _ = simulate(TrafficScene(reports=500), rng)
    register(recording, setup, rng=rng)  # compiles
    print(f"{'reports':>10}{'rows':>9}{'seconds':>9}{'ratio':>8}{'peak (GB)':>11}  dearest steps")
    first = 0.0
    for reports in SIZES:
        scene = TrafficScene(reports=reports, wrong_share=0.2, outlier_share=0.05)
        recording, setup, _ = simulate(scene, np.random.default_rng(reports))
        begin = time.perf_counter()
        found = register(recording, setup, rng=np.random.default_rng(1))
        spent = time.perf_counter() - begin
        first = first or spent
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        steps = sorted(found.seconds.items(), key=lambda item: -item[1])[:2]
        dear = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in steps)
        row = f"{reports:>10}{len(found.problem.plan):>9}{spent:>9.1f}{spent / first:>8.1f}"
        print(f"{row}{peak:>11.2f}  {dear}", flush=True)


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
