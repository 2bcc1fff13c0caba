"""Total least squares of bearings, recursive and batch, against independent forms."""

from __future__ import annotations

import numpy as np
import pytest

from probreg import BearingProblem, GaussianPrior, UnobservableError
from probreg.errors import InvalidInputError
from probreg.estimators import Recursive, RecursiveTls, TotalLeastSquares
from probreg.estimators import _tls_recursion as tls
from probreg.noise import Gaussian, HardReject, Igg3, StudentT
from probreg.scenarios import rrtls
from tests.conftest import linear_problem, passive_reports
from tests.estimators.passive_scenes import distant, igg3, scene


def transcription(problem, weigh):
    """Equations (9) to (16) and (29) with P itself, in kilometres and extended precision."""
    H, Z = problem.line_equations()
    d = np.column_stack([H, Z / 1e3]).astype(np.longdouble)
    own = (problem.own_position / 1e3).astype(np.longdouble)
    P, v = 1e8 * np.eye(3, dtype=np.longdouble), np.array([0, 0, -1], np.longdouble)

    def updated(P, v, row, w):
        if w > 0.0:
            P = P - np.outer(P @ row, P @ row) / (1.0 / w + row @ P @ row)
        v = P @ v
        return P, v / np.sqrt(v @ v)

    path, weights = [], []
    for k, row in enumerate(d):
        _, trial = updated(P, v, row, 1.0)
        X = -trial[:2] / trial[2]
        s = row[:2] @ X - row[2]
        scale = problem.sigma[k] * np.sqrt(((X - own[k]) ** 2).sum())
        weights.append(weigh(float(s / scale)) if scale > 0.0 else 1.0)
        P, v = updated(P, v, row, weights[-1])
        path.append(-v[:2] / v[2])
    return 1e3 * np.array(path, float), np.array(weights)


SETTINGS = {
    "RTLS": (RecursiveTls(), lambda u: 1.0),
    "XRTLS": (RecursiveTls(reject_above=3.0), lambda u: float(abs(u) <= 3.0)),
    "RRTLS": (RecursiveTls(Igg3(1.5, 5.0)), lambda u: igg3(u, 1.5, 5.0)),
}


@pytest.mark.parametrize("name", SETTINGS)
def test_recursion_is_the_transcription_of_the_paper(name):
    problem, _ = distant(outliers=rrtls.TABLE)
    estimator, weigh = SETTINGS[name]
    estimate = estimator.estimate(problem)
    path, weights = transcription(problem, weigh)
    # the first points have not settled on a direction yet
    np.testing.assert_allclose(estimate.path[3:], path[3:], rtol=1e-5)
    np.testing.assert_allclose(estimate.weights, weights, atol=1e-4)
    assert estimate.info["rejected"] == (weights == 0.0).sum()


def test_hard_rejection_is_a_law_too():
    problem, _ = distant(outliers=rrtls.TABLE)
    one = RecursiveTls(reject_above=3.0).estimate(problem)
    two = RecursiveTls(HardReject(3.0)).estimate(problem)
    np.testing.assert_array_equal(one.path, two.path)


@pytest.mark.parametrize("name", SETTINGS)
def test_recursion_follows_the_batch_eigenvector(name):
    problem, _ = distant()
    estimate = SETTINGS[name][0].estimate(problem)
    H, Z = problem.line_equations()
    d = np.column_stack([H, Z / 1e3]) * np.sqrt(estimate.weights)[:, None]
    for n in (50, 100, 200):
        values, vectors = np.linalg.eigh(d[:n].T @ d[:n])
        assert values[0] < values[1]
        batch = -1e3 * vectors[:2, 0] / vectors[2, 0]
        gap = np.linalg.norm(estimate.path[n - 1] - batch)
        assert gap < 2e-3 * np.linalg.norm(batch)


def test_batch_is_the_minimum_of_its_criterion():
    from scipy import optimize

    problem, _ = distant(points=60)
    H, Z = problem.line_equations()

    def criterion(X):
        return ((H @ X - Z / 1e3) ** 2).sum() / (1.0 + X @ X)

    settings = {"xatol": 1e-9, "fatol": 1e-15, "maxiter": 10_000, "maxfev": 10_000}
    found = optimize.minimize(criterion, [30.0, 180.0], method="Nelder-Mead", options=settings)
    estimate = TotalLeastSquares().estimate(problem)
    np.testing.assert_allclose(estimate.theta, 1e3 * found.x, rtol=1e-4)


def test_known_accuracies_weigh_the_lines():
    problem, _ = distant()
    sigma = np.where(np.arange(200) % 2, 1.0, 3.0) * problem.sigma
    mixed = BearingProblem(problem.bearing, problem.own_position, sigma)
    np.testing.assert_allclose(
        RecursiveTls().estimate(mixed).weights, np.where(np.arange(200) % 2, 1.0, 1.0 / 9.0)
    )
    kept = problem.part(np.arange(1, 200, 2))
    few = TotalLeastSquares().estimate(kept).theta
    apart = np.where(sigma > sigma.min(), 0.1, 1e-4)
    sharp = BearingProblem(problem.bearing, problem.own_position, apart)
    np.testing.assert_allclose(TotalLeastSquares().estimate(sharp).theta, few, rtol=1e-4)


def test_total_least_squares_is_less_biased_than_least_squares():
    gaps = {"lines": [], "total": []}
    for seed in range(40):
        problem, truth = distant(seed=seed, points=100)
        lines = Recursive(Gaussian(), omega=1e8).estimate(problem.lines())
        total = TotalLeastSquares().estimate(problem)
        gaps["lines"].append((lines.theta - truth.emitter)[1])
        gaps["total"].append((total.theta - truth.emitter)[1])
    mean, error = np.mean(gaps["total"]), np.std(gaps["total"]) / np.sqrt(40)
    assert abs(mean) < 4.0 * error
    assert np.mean(gaps["lines"]) < -2.0 * np.std(gaps["total"])


def test_claimed_covariance_is_the_spread():
    # sd of 300 estimates within 4 standard errors of the mean claim: false alarm below 1e-3
    for estimator in (TotalLeastSquares(), RecursiveTls()):
        found = [estimator.estimate(distant(seed=k)[0]) for k in range(300)]
        spread = np.std([e.theta for e in found], axis=0)
        claim = np.sqrt(np.mean([np.diag(e.covariance) for e in found], axis=0))
        assert (np.abs(spread / claim - 1.0) < 4.0 / np.sqrt(600.0) + 0.03).all()


def test_robust_start_frees_runs_that_lock():
    off = {"paper": [], "robust": []}
    robust = RecursiveTls(Igg3(1.5, 5.0), start=StudentT(1.0))
    for seed in range(60):
        problem, truth = distant(seed=seed, contamination=0.13)
        for name, estimator in (("paper", SETTINGS["RRTLS"][0]), ("robust", robust)):
            gap = np.linalg.norm(estimator.estimate(problem).theta - truth.emitter)
            off[name].append(gap / 180e3)
    assert max(off["robust"]) < 0.05
    assert np.mean(np.array(off["paper"]) > 0.05) > 0.1


def test_batch_rejects_outliers_and_counts_them():
    problem, truth = distant(outliers=rrtls.TABLE)
    plain = TotalLeastSquares().estimate(problem)
    robust = TotalLeastSquares(Igg3(1.5, 5.0), start=TotalLeastSquares(StudentT(1.0))).estimate(
        problem
    )
    gaps = [np.linalg.norm(e.theta - truth.emitter) for e in (plain, robust)]
    assert gaps[1] < 0.2 * gaps[0]
    assert robust.converged
    assert 5 <= robust.info["rejected"] <= 12
    assert (robust.weights[[119, 129, 139, 149, 179]] == 0.0).all()


def test_compiled_recursion_is_the_same_code_in_plain_python(monkeypatch):
    problem, _ = distant(outliers=rrtls.TABLE)
    compiled = SETTINGS["RRTLS"][0].estimate(problem)
    for name in ("_add", "_power_step"):
        monkeypatch.setattr(tls, name, getattr(tls, name).py_func)
    plain = tls.follow_lines.py_func
    monkeypatch.setattr("probreg.estimators.recursive_tls.follow_lines", plain)
    slow = SETTINGS["RRTLS"][0].estimate(problem)
    np.testing.assert_allclose(slow.path[5:], compiled.path[5:], rtol=1e-7)


# -- settings and bad input --------------------------------------------------------------------


def test_rejecting_everything_is_an_error():
    problem, _ = scene("none")
    with pytest.raises(UnobservableError, match="rejected all but"):
        TotalLeastSquares(HardReject(1e-6)).estimate(problem)


def test_settings_are_checked():
    with pytest.raises(InvalidInputError, match="not an array"):
        RecursiveTls(StudentT(np.array([3.0, 4.0])))
    with pytest.raises(InvalidInputError, match="pass a law"):
        RecursiveTls(Igg3)
    for bad in ({"reject_above": -3.0}, {"omega": 0.0}):
        with pytest.raises(InvalidInputError, match=next(iter(bad))):
            RecursiveTls(**bad)
    with pytest.raises(InvalidInputError, match="at least 3"):
        RecursiveTls(start_bearings=2)
    with pytest.raises(InvalidInputError, match="max_iterations"):
        TotalLeastSquares(max_iterations=0)


@pytest.mark.parametrize("estimator", [RecursiveTls(), TotalLeastSquares()])
def test_other_problems_and_priors_are_refused(estimator):
    with pytest.raises(InvalidInputError, match="takes a BearingProblem, not a LinearProblem"):
        estimator.estimate(linear_problem(1).problem)
    with pytest.raises(InvalidInputError, match="takes no prior"):
        estimator.estimate(scene()[0], GaussianPrior.from_sd(np.ones(2)))
    with pytest.raises(InvalidInputError, match="not a bearing bias"):
        estimator.estimate(BearingProblem.of(passive_reports(1), sensor_bias=True))
