"""LMS, LTS, reweighting and MM against brute force and other libraries."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy.stats import norm

from probreg import LinearProblem, UnobservableError
from probreg.errors import InvalidInputError
from probreg.estimators import (
    LeastSquares,
    Lms,
    Lts,
    Mm,
    ReweightedLeastSquares,
    required_subsets,
)
from probreg.estimators.mm import bisquare_scale
from tests.conftest import linear_problem

ROBUST = [
    Lms("equation", 2000, reweighted=False),
    Lts(subsets=2000),
    Lts(subsets=2000, unit="row"),
    Lts(subsets=2000, concentration=True),
    ReweightedLeastSquares(),
    ReweightedLeastSquares(unit="row"),
    Mm(),
]


def spoiled(seed, n=15, share=0.2):
    """Pairs of two equations, a share of them displaced by far."""
    problem, theta = linear_problem(seed, n=n, m=2)
    rng = np.random.default_rng(seed + 50)
    bad = rng.permutation(n) < round(share * n)
    y = problem.y + 80.0 * bad[:, None] * rng.normal(size=(n, 2))
    return LinearProblem(y, problem.B, problem.R), theta, bad


def equations(problem):
    white = problem.whitened()
    return white.v.ravel(), white.A.reshape(-1, white.A.shape[2])


@pytest.mark.parametrize("seed", range(5))
def test_lts_and_lms_are_the_best_of_all_elemental_solutions(seed):
    problem, _, _ = spoiled(seed)
    v, A = equations(problem)
    sums, medians = {}, {}
    for i, j in combinations(range(15), 2):
        rows = [2 * i, 2 * i + 1, 2 * j, 2 * j + 1]
        theta = np.linalg.solve(A[rows], v[rows])
        r2 = np.sort((v - A @ theta) ** 2)
        sums[i, j], medians[i, j] = r2[: int(0.75 * 30)].sum(), np.median(r2)
    lts, lms = Lts().estimate(problem), Lms("equation", reweighted=False).estimate(problem)
    assert lts.info["objective"] == pytest.approx(min(sums.values()))
    assert lms.info["median"] == pytest.approx(min(medians.values()))
    assert lts.weights.sum() == 22


@pytest.mark.parametrize("seed", range(5))
def test_concentration_never_worsens_and_comes_near_the_exact_optimum(seed):
    problem, _, _ = spoiled(seed, n=7)
    v, A = equations(problem)
    kept = int(0.75 * 14)
    exact = np.inf
    for rows in combinations(range(14), kept):
        at = list(rows)
        residual = v[at] - A[at] @ np.linalg.lstsq(A[at], v[at])[0]
        exact = min(exact, float(residual @ residual))
    plain = Lts().estimate(problem).info["objective"]
    fast = Lts(concentration=True).estimate(problem).info["objective"]
    assert exact <= fast * (1 + 1e-9)
    assert fast <= plain
    assert fast <= 1.05 * exact


def test_the_objective_is_never_above_that_of_any_random_start():
    problem, theta, _ = spoiled(9)
    v, A = equations(problem)
    found = Lts(concentration=True).estimate(problem).info["objective"]
    rng = np.random.default_rng(0)
    for start in theta + rng.normal(size=(200, 4)) * rng.choice([0.01, 0.1, 1.0], (200, 1)):
        for _ in range(50):
            keep = np.argsort((v - A @ start) ** 2)[:22]
            start = np.linalg.lstsq(A[keep], v[keep])[0]
        assert found <= np.sort((v - A @ start) ** 2)[:22].sum() * (1 + 1e-9)


@pytest.mark.parametrize("estimator", ROBUST, ids=repr)
def test_permuting_the_pairs_changes_nothing(estimator):
    problem, _, _ = spoiled(3)
    order = np.random.default_rng(1).permutation(15)
    other = LinearProblem(problem.y[order], problem.B[order], problem.R[order])
    one, two = estimator.estimate(problem), estimator.estimate(other)
    np.testing.assert_allclose(two.theta, one.theta, atol=1e-7)
    np.testing.assert_allclose(two.weights, one.weights[order], atol=1e-6)


@pytest.mark.parametrize("estimator", ROBUST, ids=repr)
def test_a_fifth_of_wrong_pairs_does_no_great_harm(estimator):
    for seed in range(8):
        problem, theta, bad = spoiled(seed, n=30)
        good = ~bad
        clean = LinearProblem(problem.y[good], problem.B[good], problem.R[good])
        sd = LeastSquares().estimate(clean).sd
        estimate = estimator.estimate(problem, rng=np.random.default_rng(0))
        # elemental solutions are several times less accurate than least squares on good rows
        assert (np.abs(estimate.theta - theta) < 12.0 * sd).all()
        ordinary = LeastSquares().estimate(problem)
        assert np.linalg.norm((estimate.theta - theta) / sd) < 0.5 * np.linalg.norm(
            (ordinary.theta - theta) / sd
        )


def test_reweighting_is_least_squares_on_what_is_kept():
    problem, _, _ = spoiled(2)
    v, A = equations(problem)
    lts = Lts().estimate(problem)
    estimate = ReweightedLeastSquares(3.0).estimate(problem)
    r2 = (v - A @ lts.theta) ** 2
    rms = np.sqrt(np.sort(r2)[:22].mean())
    assert lts.info["trimmed_rms"] == pytest.approx(rms)
    keep = np.sqrt(r2) <= 3.0 * rms
    np.testing.assert_array_equal(estimate.weights.ravel() > 0, keep)
    np.testing.assert_allclose(estimate.theta, np.linalg.lstsq(A[keep], v[keep])[0], rtol=1e-8)
    assert not estimate.info["fallback"]


def test_rejecting_pairs_keeps_or_drops_both_equations():
    problem, _, bad = spoiled(2, n=30)
    estimate = ReweightedLeastSquares(3.0, Lts(subsets=1000), "row").estimate(problem)
    assert estimate.weights.shape == (30,)
    assert (estimate.weights[bad] == 0.0).mean() > 0.8
    wide = ReweightedLeastSquares(1e6).estimate(problem, rng=np.random.default_rng(0))
    np.testing.assert_allclose(wide.theta, LeastSquares().estimate(problem).theta, rtol=1e-8)


def test_noise_free_data_and_too_tight_a_threshold_are_survived():
    problem, theta = linear_problem(4, n=12, m=2, noise=0.0)
    y = problem.y.copy()
    y[:2] += 50.0
    exact = LinearProblem(y, problem.B, problem.R)
    estimate = ReweightedLeastSquares(3.0).estimate(exact)
    np.testing.assert_allclose(estimate.theta, theta, atol=1e-8)
    assert not estimate.info["fallback"]
    noisy, _, _ = spoiled(5)
    tight = ReweightedLeastSquares(1e-25).estimate(noisy)
    assert tight.info["fallback"]
    np.testing.assert_array_equal(tight.theta, tight.info["start"])


def test_mm_scale_is_consistent_and_mm_is_efficient():
    z = np.random.default_rng(0).normal(size=200_000)
    assert bisquare_scale(4.0 * z**2, 0) == pytest.approx(2.0, rel=0.01)
    # 60 clean problems: variance against least squares, 95 % efficient; limits at 4 errors
    mm, ls = [], []
    for seed in range(60):
        problem, theta = linear_problem(seed, n=100, m=2)
        mm.append(Mm().estimate(problem, rng=np.random.default_rng(0)).theta - theta)
        ls.append(LeastSquares().estimate(problem).theta - theta)
    ratio = np.mean(np.square(mm)) / np.mean(np.square(ls))
    assert 0.9 < ratio < 1.3


def test_bisquare_scale_solves_its_equation():
    d2 = np.random.default_rng(2).chisquare(1, 400) * 9.0
    s = bisquare_scale(d2, 4)
    u = np.minimum(d2 / (1.5476 * s) ** 2, 1.0)
    assert np.sum(1.0 - (1.0 - u) ** 3) / 396 == pytest.approx(0.5, abs=1e-9)
    # the constant makes it 1 for the standard normal: known expectation by quadrature
    grid = np.linspace(-12, 12, 200_001)
    loss = 1.0 - (1.0 - np.minimum(grid**2 / 1.5476**2, 1.0)) ** 3
    assert np.trapezoid(loss * norm.pdf(grid), grid) == pytest.approx(0.5, abs=1e-4)


@pytest.mark.parametrize(("share", "subsets"), [(0.2, 5), (0.3, 7), (0.0, 1), (0.5, 17)])
def test_required_subsets_is_equation_25(share, subsets):
    assert required_subsets(share, 2, 0.99) == subsets
    if share > 0.0:
        failing = (1.0 - (1.0 - share) ** 2) ** subsets
        assert failing <= 0.01 + 1e-12


def test_bad_settings_and_too_little_data():
    for coverage in (0.4, 1.1, np.nan):
        with pytest.raises(InvalidInputError, match="coverage"):
            Lts(coverage)
    for make in (lambda: Lts(unit="pair"), lambda: ReweightedLeastSquares(unit="pair")):
        with pytest.raises(InvalidInputError, match="'row' or 'equation'"):
            make()
    with pytest.raises(InvalidInputError, match="threshold"):
        ReweightedLeastSquares(0.0)
    for bad in ((1.0, 2, 0.99), (0.2, 0, 0.99), (0.2, 2, 1.0)):
        with pytest.raises(InvalidInputError, match="required_subsets"):
            required_subsets(*bad)
    one, _ = linear_problem(1, n=1, m=2)
    for estimator in ROBUST:
        with pytest.raises((UnobservableError, InvalidInputError), match=r"2 equations|subset"):
            estimator.estimate(one)
    problem, _ = linear_problem(1, n=20, m=2)
    same = LinearProblem(
        np.repeat(problem.y[:1], 6, 0),
        np.repeat(problem.B[:1], 6, 0),
        np.repeat(problem.R[:1], 6, 0),
    )
    for estimator in ROBUST:  # duplicate reports of one target
        with pytest.raises(UnobservableError, match="do not determine"):
            estimator.estimate(same)
