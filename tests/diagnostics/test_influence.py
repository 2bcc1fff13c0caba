"""Influence functions against brute force, and the bound along a path."""

from __future__ import annotations

import numpy as np
import pytest

from probreg import AssociatedReports, BearingProblem, LinearProblem, ReportProblem
from probreg.diagnostics import (
    cramer_rao_bound,
    cramer_rao_path,
    empirical_influence,
    m_influence,
)
from probreg.diagnostics.influence import mean_curvature
from probreg.errors import InvalidInputError
from probreg.estimators import Irls, LeastSquares, Lms
from probreg.noise import Contaminated, Gaussian, Huber, Hyperbolic, Igg3, StudentT
from tests.conftest import (
    EMITTER,
    PAIR_BIAS,
    linear_problem,
    passive_reports,
    polar_reports,
    radar_pair,
)

SHIFTS = np.array([-3.0, -0.5, 0.0, 1.0, 2.5])


def test_moving_a_report_moves_least_squares_linearly():
    problem, _ = linear_problem(1, n=80)
    moved = empirical_influence(LeastSquares(), problem, 5, SHIFTS, component=1)
    theory = m_influence(problem, Gaussian(), 5, SHIFTS, component=1)
    # least squares is linear: its first-order influence is all of it
    np.testing.assert_allclose(moved, theory, atol=1e-10)
    np.testing.assert_allclose(moved[4], -2.5 / 3.0 * moved[0], atol=1e-12)


@pytest.mark.parametrize("law", [Huber(1.345), Igg3(1.5, 5.0), StudentT(4.0)])
def test_theory_is_the_mean_of_what_happens(law):
    # 40 noises of one design, each with the row's own error taken away
    design, theta = linear_problem(4, n=400, m=2, p=2)
    root = np.linalg.cholesky(design.R)
    rng = np.random.default_rng(6)
    moved = []
    for _ in range(40):
        noise = (root @ rng.standard_normal((400, 2, 1)))[..., 0]
        noise[7] = 0.0
        problem = LinearProblem(design.B @ theta + noise, design.B, design.R)
        moved.append(empirical_influence(Irls(law), problem, 7, 2.0 * SHIFTS))
    theory = m_influence(design, law, 7, 2.0 * SHIFTS)
    np.testing.assert_allclose(np.mean(moved, axis=0), theory, atol=0.03 * np.abs(theory).max())


@pytest.mark.parametrize("m", [1, 2, 3])
@pytest.mark.parametrize(
    "law",
    [
        Huber(1.0),
        Igg3(1.5, 5.0, scale=1.2),
        StudentT(3.0),
        Contaminated(0.2, 5.0),
        Hyperbolic(0.1),
    ],
)
def test_mean_curvature_is_the_mean_of_the_curvature(law, m):
    # the right side differentiates the score at a million draws, the left integrates it
    v = np.random.default_rng(3).standard_normal((1_000_000, m))
    across, along = law.curvature(v)
    mean = np.mean(((m - 1) * across + along) / m)
    error = np.std(((m - 1) * across + along) / m) / 1e3
    assert mean_curvature(law, m) == pytest.approx(mean, abs=4.5 * error + 1e-4)


def test_gaussian_curvature_is_one():
    assert mean_curvature(Gaussian(), 3) == pytest.approx(1.0)


def test_one_report_of_one_sensor_moves():
    data = polar_reports(radar_pair(), PAIR_BIAS, seed=3, n=40)
    both = ReportProblem(
        AssociatedReports(data.sensors, tuple(v[:15] for v in data.values)),
        AssociatedReports(data.sensors, tuple(v[15:] for v in data.values)),
    )
    moved = both.shifted(18, 4, 1e-3)  # second sensor, azimuth, row 3 of the second group
    assert moved.reports[1].values[1][3, 1] == data.values[1][18, 1] + 1e-3
    change = moved.residual(PAIR_BIAS) - both.residual(PAIR_BIAS)
    np.testing.assert_array_equal(np.flatnonzero(change.any(axis=1)), [18])


def test_a_redescending_estimate_forgets_a_gross_error():
    problem = BearingProblem.of(passive_reports(5, n=100))
    sigma = problem.sigma[0]
    shifts = sigma * np.array([1.5, 4.0, 30.0, 60.0])
    robust = empirical_influence(Irls(Igg3(1.5, 5.0)), problem, 50, shifts)
    plain = empirical_influence(LeastSquares(), problem, 50, shifts)
    np.testing.assert_allclose(robust[2], robust[3], atol=1e-3)
    assert np.linalg.norm(plain[3]) > 10.0 * np.linalg.norm(plain[0])


def test_random_estimators_restart_from_the_seed():
    problem, _ = linear_problem(2, n=60)
    none = empirical_influence(Lms(subsets=50), problem, 3, np.zeros(2), seed=4)
    np.testing.assert_array_equal(none, 0.0)


def test_bad_rows_and_shifts_are_refused():
    problem, _ = linear_problem(2, n=60)
    with pytest.raises(InvalidInputError, match="row 60 does not exist"):
        empirical_influence(LeastSquares(), problem, 60, SHIFTS)
    with pytest.raises(InvalidInputError, match=r"shifts\[1\] is nan"):
        m_influence(problem, Gaussian(), 0, np.array([0.0, np.nan]))


@pytest.mark.parametrize("law", [Gaussian(), StudentT(4.0)])
def test_the_bound_along_a_path_is_that_of_each_prefix(law):
    problem = BearingProblem.of(passive_reports(2))
    path = cramer_rao_path(problem, EMITTER, law)
    assert np.isnan(path[0]).all()
    for n in (5, 20, 60):
        whole = cramer_rao_bound(problem.part(slice(n)), EMITTER, law)
        np.testing.assert_allclose(path[n - 1], whole, rtol=1e-8)


def test_components_that_do_not_exist_are_refused():
    linear, _ = linear_problem(2, n=60)
    bearings = BearingProblem.of(passive_reports(5))
    reports = ReportProblem(polar_reports(radar_pair(), PAIR_BIAS, seed=3, n=40))
    cases = ((linear, -1), (linear, 3), (bearings, 1), (bearings, -1), (reports, 9))
    for problem, component in cases:
        with pytest.raises(InvalidInputError, match=f"no component {component}"):
            empirical_influence(LeastSquares(), problem, 1, np.array([0.01]), component)
