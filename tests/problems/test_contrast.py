from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag

from probreg import AssociatedReports, PositionSensor, Radar2D, ReportProblem
from probreg.errors import InvalidInputError
from probreg.estimators import LeastSquares
from tests.conftest import PAIR_BIAS, polar_reports, radar_pair


def noiseless(n=40):
    return polar_reports(radar_pair(), PAIR_BIAS, seed=2, n=n, noise=0.0)


def test_sign_report_is_truth_plus_bias_and_a_correction_subtracts():
    data = noiseless()
    corrected = tuple(v - b for v, b in zip(data.values, PAIR_BIAS.reshape(2, 3), strict=True))
    problem = ReportProblem(AssociatedReports(data.sensors, corrected))
    first, second = data.sensors
    plain = first.to_cartesian(corrected[0], unbiased=False)
    np.testing.assert_allclose(plain, second.to_cartesian(corrected[1], unbiased=False), atol=1e-6)
    # residuals of the problem: contrast of corrected reports, sensor i minus sensor j
    at_truth = ReportProblem(data).residual(PAIR_BIAS)
    np.testing.assert_allclose(at_truth, problem.residual(np.zeros(6)), atol=1e-6)
    assert np.abs(ReportProblem(data).residual(np.zeros(6))).max() > 50.0


def test_the_one_shot_form_is_the_papers_equation_5():
    # Z = z_i - z_j + I - J with sensor-relative z, B = [B_i, -B_j] at the given positions
    data = noiseless()
    at = data.positions(unbiased=False)
    problem = ReportProblem(data).one_shot([at])
    for k in (0, 17):
        parts, columns = [], []
        for sensor, value, where in zip(data.sensors, data.values, at, strict=True):
            rho, az, el = value[k]
            az = np.pi / 2 - az if sensor.from_north else az
            local = rho * np.array([np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)])
            parts.append(local + np.array(sensor.position))
            columns.append(sensor.sensitivity(where[k : k + 1])[0])
        np.testing.assert_allclose(problem.y[k], parts[0] - parts[1], atol=1e-6)
        np.testing.assert_allclose(problem.B[k], np.hstack([columns[0], -columns[1]]))
        expected = sum(s.covariance(w[k : k + 1])[0] for s, w in zip(data.sensors, at, strict=True))
        np.testing.assert_allclose(problem.R[k], expected)


def test_jacobian_by_finite_differences(pair_problem):
    # exact where reports carry no noise; the unbiased factors leave a relative 1e-4
    problem = ReportProblem(noiseless())
    jacobian = problem.jacobian(PAIR_BIAS)
    for k, step in enumerate([0.1, 1e-6, 1e-6] * 2):
        e = step * np.eye(6)[k]
        numeric = (problem.residual(PAIR_BIAS + e) - problem.residual(PAIR_BIAS - e)) / (2 * step)
        size = np.abs(numeric).max()
        np.testing.assert_allclose(jacobian[..., k], numeric, atol=2e-4 * size)


def test_linearised_problem_is_tangent(pair_problem):
    theta = np.array([5.0, 1e-3, 0.0, -5.0, 0.0, 1e-3])
    linear = pair_problem.linearise(theta)
    np.testing.assert_allclose(linear.residual(theta), pair_problem.residual(theta), atol=1e-9)
    np.testing.assert_allclose(linear.jacobian(theta), pair_problem.jacobian(theta))
    assert linear.names == (
        "i.range",
        "i.azimuth",
        "i.elevation",
        "j.range",
        "j.azimuth",
        "j.elevation",
    )
    assert linear.units == ("m", "rad", "rad") * 2


def test_the_fused_position_is_the_precision_weighted_mean(pair_problem):
    data = pair_problem.reports[0]
    linear = pair_problem.linearise(np.zeros(6))
    x = data.positions()
    where = x
    for _ in range(2):
        weights = [np.linalg.inv(s.covariance(w)) for s, w in zip(data.sensors, where, strict=True)]
        fused = np.stack(
            [np.linalg.solve(a + b, a @ p + b @ q) for a, b, p, q in zip(*weights, *x, strict=True)]
        )
        where = (fused, fused)
    expected = [s.sensitivity(fused) for s in data.sensors]
    np.testing.assert_allclose(
        linear.B, np.concatenate([expected[0], -expected[1]], axis=2), rtol=1e-8
    )


def three_sensors():
    return (
        Radar2D((0.0, 0.0), 20.0, 2e-3, name="a"),
        Radar2D((9e3, 1e3), 30.0, 3e-3, name="b"),
        PositionSensor(((400.0, 50.0), (50.0, 300.0)), name="c"),
    )


def test_three_sensors_enter_one_row_with_their_full_covariance():
    bias = np.array([30.0, 4e-3, -20.0, 2e-3, 40.0, -60.0])
    data = polar_reports(three_sensors(), bias, seed=9, n=50)
    linear = ReportProblem(data).one_shot()
    assert linear.y.shape == (50, 4)
    x = data.positions(unbiased=False)
    C = np.kron([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]], np.eye(2))
    k = 13
    blocks = [s.covariance(p[k : k + 1])[0] for s, p in zip(data.sensors, x, strict=True)]
    np.testing.assert_allclose(linear.R[k], C @ block_diag(*blocks) @ C.T)
    H = block_diag(*(s.sensitivity(p[k : k + 1])[0] for s, p in zip(data.sensors, x, strict=True)))
    np.testing.assert_allclose(linear.B[k], C @ H)
    np.testing.assert_allclose(linear.y[k], C @ np.concatenate([p[k] for p in x]))


def test_eliminating_the_target_is_estimating_it_too():
    # oracle: joint least squares over the bias and every target position
    bias = np.array([30.0, 4e-3, -20.0, 2e-3, 0.0, 0.0])
    sensors = three_sensors()
    data = polar_reports(sensors, bias, seed=10, n=25)
    problem = ReportProblem(data)
    linear = problem.one_shot()
    x = data.positions(unbiased=False)
    rows, right = [], []
    for k in range(25):
        for j, (sensor, p) in enumerate(zip(sensors, x, strict=True)):
            root = np.linalg.inv(np.linalg.cholesky(sensor.covariance(p[k : k + 1])[0]))
            row = np.zeros((2, 6 + 50))
            row[:, 2 * j : 2 * j + 2] = sensor.sensitivity(p[k : k + 1])[0]
            row[:, 6 + 2 * k : 8 + 2 * k] = np.eye(2)
            rows.append(root @ row)
            right.append(root @ p[k])
    tight = np.zeros((2, 56))
    tight[:, 4:6] = 1e3 * np.eye(2)  # sensor c is calibrated
    joint = np.linalg.lstsq(np.vstack([*rows, tight]), np.concatenate([*right, np.zeros(2)]))[0]
    from probreg import GaussianPrior

    prior = GaussianPrior.from_sd(np.array([1e6, 1e3, 1e6, 1e3, 1e-3, 1e-3]))
    got = LeastSquares().estimate(linear, prior)
    scale = np.array([1.0, 1e-3, 1.0, 1e-3])
    np.testing.assert_allclose(got.theta[:4] / scale, joint[:4] / scale, atol=1e-4)


def test_groups_of_different_sensors_share_their_biases():
    a, b, c = three_sensors()
    bias = {"a": [30.0, 4e-3], "b": [-20.0, 2e-3], "c": [0.0, 0.0]}

    def group(*sensors, seed):
        return polar_reports(sensors, np.concatenate([bias[s.name] for s in sensors]), seed, n=300)

    problem = ReportProblem(group(a, b, c, seed=1), group(b, c, seed=2), group(a, c, seed=3))
    assert [s.name for s in problem.sensors] == ["a", "b", "c"]
    np.testing.assert_array_equal(np.unique(problem.size, return_counts=True), [[2, 4], [600, 300]])
    from probreg import GaussianPrior

    prior = GaussianPrior.from_sd(np.array([100.0, 0.1, 100.0, 0.1, 1e-3, 1e-3]))
    estimate = LeastSquares().estimate(problem, prior)
    # 4 biases at 4.5 standard deviations: false alarm rate 3e-5
    truth = np.array([30.0, 4e-3, -20.0, 2e-3])
    assert (np.abs(estimate.theta[:4] - truth) < 4.5 * estimate.sd[:4]).all()
    padded = problem.residual(estimate.theta)[problem.size == 2][:, 2:]
    np.testing.assert_array_equal(padded, 0.0)


def test_bad_groups():
    a, b, _ = three_sensors()
    one = polar_reports((a, b), np.zeros(4), seed=1)
    other = Radar2D((5.0, 0.0), 20.0, 2e-3, name="a")
    with pytest.raises(InvalidInputError, match="two different sensors are called 'a'"):
        ReportProblem(one, polar_reports((other, b), np.zeros(4), seed=2))
    again = Radar2D(np.array([0.0, 0.0]), 20, 2e-3, name="a")  # the same sensor, built anew
    assert again == a
    assert len(ReportProblem(one, polar_reports((again, b), np.zeros(4), seed=2)).sensors) == 2
    nobody = AssociatedReports(one.sensors, (np.zeros((0, 2)), np.zeros((0, 2))), np.zeros(0))
    both = ReportProblem(one, nobody).linearise(np.zeros(4))
    np.testing.assert_array_equal(both.y, ReportProblem(one).linearise(np.zeros(4)).y)
    untimed = AssociatedReports(one.sensors, one.values)
    with pytest.raises(InvalidInputError, match="some groups of reports have times"):
        ReportProblem(one, untimed)
    with pytest.raises(InvalidInputError, match="no target was seen in common"):
        ReportProblem()
    with pytest.raises(InvalidInputError, match="one position a report"):
        ReportProblem(one).one_shot([(np.zeros((3, 2)), np.zeros((3, 2)))])
    with pytest.raises(InvalidInputError, match=r"theta\[1\] is nan"):
        ReportProblem(one).residual(np.array([0.0, np.nan, 0.0, 0.0]))


def test_impossible_accuracies_are_named():
    data = polar_reports(radar_pair(), PAIR_BIAS, seed=1, n=20)
    import dataclasses

    absurd = tuple(
        dataclasses.replace(s, sigma_range=1e3, sigma_azimuth=1e-13, sigma_elevation=1e-13)
        for s in data.sensors
    )
    with pytest.raises(InvalidInputError, match=r"(numerically singular|not positive definite)"):
        LeastSquares().estimate(ReportProblem(AssociatedReports(absurd, data.values)))
