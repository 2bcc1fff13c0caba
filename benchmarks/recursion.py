"""The compiled recursion against the same equations in plain numpy, in one run.

Run by `make benchmark`. Prints milliseconds and the ratio; nothing is asserted.
"""

from __future__ import annotations

import platform
import timeit
from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from probreg import ReportProblem
from probreg.estimators import Recursive
from probreg.estimators._recursion import Drift, Rows, State, Written, recurse
from probreg.noise import (
    Contaminated,
    Gaussian,
    Huber,
    Hyperbolic,
    NoiseLaw,
    StudentT,
)
from probreg.problems.linear import LinearProblem
from probreg.scenarios.ralad import CASES, simulate

LAWS = {
    "RLS": Gaussian(),
    "Huber": Huber(1.345, True),
    "RALAD": Hyperbolic(1e-3),
    "Student-t": StudentT(3.0),
    "contaminated": Contaminated(0.3, 30.0),
}


def best(function: Callable[[], object], repeats: int) -> float:
    """Shortest of several times, seconds."""
    return min(timeit.repeat(function, number=1, repeat=repeats))


def plain_numpy(problem: LinearProblem, law: NoiseLaw) -> np.ndarray:
    """The paper's recursion row by row with m x m inverses, milliradians inside."""
    unit = np.array([1.0, 1e-3, 1e-3] * 2)
    b, P = np.zeros(6), 1e6 * np.eye(6)
    rows = problem.whitened()
    for v, A in zip(rows.v, rows.A * unit, strict=True):
        e = v - A @ b
        w = np.atleast_1d(law.weight(e[None])[0])
        W = P @ A.T @ np.linalg.inv(A @ P @ A.T + np.diag(np.broadcast_to(1.0 / w, 3)))
        b = b + W @ e
        P = P - W @ A @ P
    return b * unit


def compiled_only(problem: LinearProblem, law: NoiseLaw) -> Callable[[], None]:
    """The loop alone, its inputs ready: what the paper's Table 6 times."""
    unit = np.array([1.0, 1e-3, 1e-3] * 2)
    white = problem.whitened()
    n = len(white.v)
    rows = Rows(white.v, np.ascontiguousarray(white.A * unit), white.size)
    written = Written(np.empty((n, 3)), np.empty((n, 6)), np.empty((0, 6, 6)))
    weight, numbers = law.compiled_weight, law.numbers
    still = Drift(np.full(n, -1), np.empty((0, 6, 6)), np.empty((0, 6, 6)), 1.0)

    def run() -> None:
        state = State(np.zeros(6), 1e3 * np.eye(6))
        recurse(rows, weight, numbers, law.componentwise, still, state, written)

    return run


def main() -> None:
    """Print the table."""
    data, truth = simulate(CASES[1], np.random.default_rng(0))
    problem = ReportProblem(data).one_shot([truth.positions])
    print(f"{len(data)} updates of 6 parameters, one thread; {platform.processor() or 'cpu'}")
    print(f"{'':<14}{'loop (ms)':>10}{'estimate (ms)':>15}{'plain numpy (ms)':>18}{'ratio':>8}")
    with threadpool_limits(1):
        for name, law in LAWS.items():
            loop = compiled_only(problem, law)
            loop()
            inner = best(loop, 20)
            whole = best(lambda law=law: Recursive(law).estimate(problem), 10)
            slow = best(lambda law=law: plain_numpy(problem, law), 1)
            cells = f"{1e3 * inner:>10.2f}{1e3 * whole:>15.1f}{1e3 * slow:>18.0f}"
            print(f"{name:<14}{cells}{slow / inner:>8.0f}")


if __name__ == "__main__":
    main()
