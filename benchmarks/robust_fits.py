"""LTS and consensus: one small frame, and ten thousand pairs, beside scikit-learn in one run.

Run by `make benchmark`. Prints milliseconds and ratios; nothing is asserted. scikit-learn has
no LTS; its RANSAC is the nearest kept estimator of the kind, here on the same equations.
"""

from __future__ import annotations

import timeit
from collections.abc import Callable

import numpy as np
from sklearn.linear_model import LinearRegression, RANSACRegressor
from threadpoolctl import threadpool_limits

from probreg import LinearProblem, ReportProblem
from probreg.association import nearest_neighbours
from probreg.estimators import Lms, Lts, Mm, ReweightedLeastSquares
from probreg.joint import Consensus, Reassociation
from probreg.scenarios.lts import READINGS, simulate
from probreg.sensors.reports import pair_up


def best(function: Callable[[], object], repeats: int) -> float:
    """Shortest of several times, milliseconds."""
    return 1e3 * min(timeit.repeat(function, number=1, repeat=repeats))


def large_problem(pairs: int, wrong: float) -> LinearProblem:
    """Targets of the LTS scene over many frames, a share of them wrongly paired."""
    rng = np.random.default_rng(0)
    scene = READINGS["symmetric"]
    targets = np.array(scene.centre_m) + rng.uniform(-20e3, 20e3, (pairs, 2))
    first, second = scene.sensors
    halves = scene.bias.reshape(2, 2)
    swapped = np.where(rng.random(pairs) < wrong, rng.permutation(pairs), np.arange(pairs))
    data = (first.to_report(targets) + halves[0], second.to_report(targets[swapped]) + halves[1])
    from probreg import AssociatedReports

    return ReportProblem(AssociatedReports((first, second), data)).one_shot()


def ransac(problem: LinearProblem) -> Callable[[], object]:
    """scikit-learn's RANSAC on the whitened equations, as many trials as LTS has subsets."""
    rows = problem.whitened()
    v, A = rows.v.ravel(), rows.A.reshape(-1, rows.A.shape[2])
    scaled = A / np.linalg.norm(A, axis=0)
    model = RANSACRegressor(
        LinearRegression(fit_intercept=False), min_samples=4, max_trials=500,
        stop_probability=1.0, random_state=0,
    )  # fmt: skip
    return lambda: model.fit(scaled, v)


def main() -> None:
    """Print the table."""
    (first, second), _ = simulate(READINGS["literal"], np.random.default_rng(3))
    pairs = nearest_neighbours(first.positions(), second.positions(), 8_000.0)
    small = ReportProblem(pair_up(first, second, pairs)).one_shot()
    small.whitened()
    with threadpool_limits(1):
        print(f"{len(pairs)} pairs, all subsets, one thread (ms)")
        for method in (Lms("equation"), Lts(), Lts(concentration=True),
                       ReweightedLeastSquares(), Mm()):  # fmt: skip
            run = lambda method=method: method.estimate(small)  # noqa: E731
            print(f"  {best(run, 20):8.2f}  {method}")
        for joint in (Reassociation(), Consensus()):
            run = lambda joint=joint: joint.estimate(first, second)  # noqa: E731
            print(f"  {best(run, 10):8.2f}  {joint}")
        large = large_problem(10_000, 0.2)
        large.whitened()
        print("10000 pairs, 20 % wrong, 500 subsets, one thread (ms)")
        for method in (Lts(), Lts(concentration=True)):
            run = lambda m=method: m.estimate(large, rng=np.random.default_rng(0))  # noqa: E731
            print(f"  {best(run, 3):8.0f}  {method}")
        print(f"  {best(ransac(large), 1):8.0f}  scikit-learn RANSACRegressor, 500 trials")


if __name__ == "__main__":
    main()
