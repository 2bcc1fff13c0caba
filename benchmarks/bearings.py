"""Bearings-only filters: compiled against the same code in plain Python, in one run.

Run by `make benchmark`. Prints microseconds of a pass of 201 bearings and ratios; nothing is
asserted.
"""

from __future__ import annotations

import timeit
from collections.abc import Callable
from unittest import mock

import numpy as np
from threadpoolctl import threadpool_limits

from probreg import BearingProblem
from probreg.estimators import (
    Estimator,
    ExtendedKalman,
    Irls,
    LeastSquares,
    LinesOfSight,
    Recursive,
    RecursiveTls,
    TotalLeastSquares,
    _bearing_filter,
    _tls_recursion,
    extended_kalman,
    recursive_tls,
)
from probreg.noise import Gaussian, Igg3, StudentT
from probreg.scenarios.rekf import RekfScene, simulate

METHODS: dict[str, Estimator] = {
    "EKF": ExtendedKalman(),
    "REKF": ExtendedKalman(Igg3(1.2, 4.0)),
    "chi2-REKF": ExtendedKalman(Igg3(1.2, 4.0), robust_above=7.879),
    "RTLS": RecursiveTls(),
    "RRTLS": RecursiveTls(Igg3(1.5, 5.0)),
    "RLS on lines": LinesOfSight(Recursive(Gaussian(), omega=1e8)),
    "TLS, batch": TotalLeastSquares(),
    "Gaussian ML": LeastSquares(),
    "Student-t ML": Irls(StudentT(4.0)),
}
COMPILED = (
    (extended_kalman, "filter_bearings"),
    (_bearing_filter, "_predict"),
    (_bearing_filter, "_repeat"),
    (_bearing_filter, "_update"),
    (recursive_tls, "follow_lines"),
    (_tls_recursion, "_add"),
    (_tls_recursion, "_power_step"),
)


def best(function: Callable[[], object], repeats: int) -> float:
    """Shortest of several times, microseconds."""
    return 1e6 * min(timeit.repeat(function, number=1, repeat=repeats))


def in_plain_python(function: Callable[[], object]) -> float:
    """Time with every compiled function replaced by its own source."""
    patches = [mock.patch.object(m, name, getattr(m, name).py_func) for m, name in COMPILED]
    for patch in patches:
        patch.start()
    try:
        return best(function, 2)
    finally:
        for patch in patches:
            patch.stop()


def main() -> None:
    """Print the table."""
    data, _ = simulate(RekfScene(outliers="one_sided"), np.random.default_rng(0))
    problem = BearingProblem.of(data)
    print(f"{len(data)} bearings, one thread; whole `estimate` with its checks")
    print(f"{'':<16}{'time (us)':>10}{'plain Python (us)':>20}{'ratio':>8}")
    with threadpool_limits(1):
        for name, method in METHODS.items():

            def run(method: Estimator = method) -> object:
                return method.estimate(problem)

            run()
            quick = best(run, 50)
            line = f"{name:<16}{quick:>10.0f}"
            if isinstance(method, ExtendedKalman | RecursiveTls):
                slow = in_plain_python(run)
                line += f"{slow:>20.0f}{slow / quick:>8.0f}"
            print(line)


if __name__ == "__main__":
    main()
