"""The bearing problem: residuals, Jacobians, exact posteriors, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize

from probreg import BearingProblem, GaussianPrior, Posterior, UnobservableError
from probreg.errors import InvalidInputError
from probreg.estimators import ExtendedKalman, Irls, LeastSquares, RecursiveTls, TotalLeastSquares
from probreg.noise import Contaminated, Gaussian, Huber, StudentT
from tests.conftest import EMITTER, passive_reports

NEAR = np.array([5.3e3, 9.6e3])


def problem(seed=1, bias=False, north=False, **kwargs):
    return BearingProblem.of(passive_reports(seed, from_north=north, **kwargs), bias)


@pytest.mark.parametrize("north", [False, True])
@pytest.mark.parametrize("bias", [False, True])
def test_jacobian_is_the_finite_difference_of_the_residual(bias, north):
    p = problem(bias=bias, north=north)
    theta = np.append(NEAR, 0.01)[: len(p.names)]
    for k, step in enumerate((1e-2, 1e-2, 1e-7)[: len(theta)]):
        h = step * np.eye(len(theta))[k]
        slope = (p.residual(theta + h) - p.residual(theta - h)) / (2.0 * step)
        np.testing.assert_allclose(p.jacobian(theta)[:, :, k], slope, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("north", [False, True])
def test_a_bias_adds_to_the_report_and_a_correction_subtracts(north):
    clean, shifted = (problem(noise=0.0, bias=True, north=north),) * 2
    shifted = BearingProblem.of(passive_reports(1, noise=0.0, bias=0.02, from_north=north), True)
    np.testing.assert_allclose(clean.residual(np.array([*EMITTER, 0.0])), 0.0, atol=1e-12)
    np.testing.assert_allclose(shifted.residual(np.array([*EMITTER, 0.02])), 0.0, atol=1e-12)
    assert shifted.names == ("emitter.x", "emitter.y", "sensor.bearing")
    assert shifted.units == ("m", "m", "rad")


def test_residuals_do_not_jump_where_angles_do():
    own = np.stack([np.zeros(21), np.linspace(-1e3, 1e3, 21)], axis=1)
    away = np.array([-9e3, 0.0]) - own
    bearing = np.arctan2(away[:, 1], away[:, 0]) + 1e-3
    assert np.ptp(bearing) > 6.0  # on both sides of the cut
    p = BearingProblem(bearing, own, 1e-3)
    np.testing.assert_allclose(p.residual(np.array([-9e3, 0.0])), 1e-3, atol=1e-12)
    assert np.linalg.norm(LeastSquares().estimate(p).theta - [-9e3, 0.0]) < 100.0


def test_linear_form_is_tangent():
    p = problem(bias=True)
    theta = np.array([*NEAR, 0.004])
    linear = p.linearise(theta)
    np.testing.assert_allclose(linear.residual(theta), p.residual(theta), atol=1e-9)
    step = np.array([0.5, -0.3, 1e-6])
    np.testing.assert_allclose(linear.residual(theta + step), p.residual(theta + step), atol=1e-8)
    np.testing.assert_allclose(linear.R[:, 0, 0], p.sigma**2)


def test_lines_of_sight_meet_in_the_emitter():
    p = problem(noise=0.0)
    np.testing.assert_allclose(p.lines().residual(EMITTER), 0.0, atol=1e-8)
    np.testing.assert_allclose(p.meeting_point(), EMITTER, rtol=1e-9)
    noisy = problem()
    H, Z = noisy.line_equations()
    expected = np.linalg.solve(H.T @ H, H.T @ Z)
    np.testing.assert_allclose(LeastSquares().estimate(noisy.lines()).theta, expected, rtol=1e-9)
    with pytest.raises(InvalidInputError, match="not in a bearing bias"):
        problem(bias=True).lines()


@pytest.mark.parametrize("bias", [False, True])
def test_least_squares_is_that_of_scipy(bias):
    p = problem(seed=3, bias=bias)
    start = np.append(NEAR, 0.0)[: len(p.names)]

    def whitened(theta):
        away = theta[:2] - p.own_position
        own = theta[2] if bias else 0.0
        left = p.bearing - np.arctan2(away[:, 1], away[:, 0]) - own
        return np.angle(np.exp(1j * left)) / p.sigma

    scale = (1e3, 1e3, 1e-3)[: len(start)]
    found = optimize.least_squares(whitened, start, x_scale=scale, xtol=1e-15, ftol=1e-15)
    estimate = LeastSquares().estimate(p)
    np.testing.assert_allclose(estimate.theta, found.x, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(
        estimate.covariance, np.linalg.inv(found.jac.T @ found.jac), rtol=1e-3
    )


@pytest.mark.parametrize(
    ("law", "loss"),
    [
        (Huber(1.345), lambda r: np.where(r < 1.345, 0.5 * r**2, 1.345 * r - 0.5 * 1.345**2)),
        (StudentT(4.0), lambda r: 2.5 * np.log1p(r**2 / 4.0)),
        (
            Contaminated(0.1, 10.0),
            lambda r: -np.log(0.9 * np.exp(-0.5 * r**2) + 0.01 * np.exp(-0.005 * r**2)),
        ),
    ],
)
def test_maximum_likelihood_is_a_direct_minimum(law, loss):
    reports = passive_reports(4)
    spoiled = reports.bearing.copy()
    spoiled[10:16] += 0.06
    p = BearingProblem(spoiled, reports.own_position, reports.sensor.sigma_bearing)

    def objective(theta):
        away = theta - p.own_position
        return loss(np.abs(p.bearing - np.arctan2(away[:, 1], away[:, 0])) / p.sigma).sum()

    settings = {"xatol": 1e-6, "fatol": 1e-12, "maxiter": 4000}
    best = optimize.minimize(objective, EMITTER, method="Nelder-Mead", options=settings).x
    np.testing.assert_allclose(Irls(law).estimate(p).theta, best, atol=0.02)


@pytest.mark.parametrize("law", [Gaussian(), StudentT(4.0), Contaminated(0.1, 10.0)])
def test_posterior_is_exact_far_from_its_mode(law):
    p = problem(seed=5, bias=True, north=True)
    prior = GaussianPrior.from_sd(np.array([5e3, 5e3, 0.02]), np.array([*EMITTER, 0.0]))
    posterior = Posterior(p, law, prior)
    theta = np.array([[4.0e3, 13e3, 0.01], [9e3, 8e3, -0.02]])
    expected = []
    for t in theta:
        rows = law.log_density(p.residual(t) / p.sigma[:, None]) - np.log(p.sigma)
        expected.append(rows.sum() + prior.log_density(t))
    np.testing.assert_allclose(posterior.log_prob(theta), expected, rtol=1e-10)
    assert posterior.log_likelihood(theta).shape == (2, len(p))
    for k, step in enumerate((1.0, 1.0, 1e-5)):
        h = step * np.eye(3)[k]
        slope = (posterior.log_prob(theta + h) - posterior.log_prob(theta - h)) / (2.0 * step)
        np.testing.assert_allclose(posterior.grad_log_prob(theta)[:, k], slope, rtol=2e-4)
    # the linear form at the mode, by contrast, is far off out there
    linear = Posterior(posterior.linear, law, prior)
    assert (np.abs(linear.log_prob(theta) - expected) > 1.0).all()


def test_mode_has_no_slope():
    posterior = Posterior(problem(seed=6), StudentT(3.0))
    mode = posterior.mode()
    sd = np.sqrt(np.diag(posterior.laplace_covariance(mode)))
    assert mode.converged
    assert (np.abs(posterior.grad_log_prob(mode.theta)) * sd < 1e-4).all()


def test_start_bears_outliers():
    reports = passive_reports(7)
    bearing = reports.bearing.copy()
    bearing[::5] += 0.7
    p = BearingProblem(bearing, reports.own_position, reports.sensor.sigma_bearing)
    assert np.linalg.norm(p.start - EMITTER) < 1e3
    assert np.linalg.norm(p.meeting_point() - EMITTER) > 1e3  # least squares does not
    assert np.linalg.norm(Irls(StudentT(3.0)).estimate(p).theta - EMITTER) < 100.0


def test_a_shifted_report_moves_one_residual():
    p = problem()
    moved = p.shifted(7, 0, 0.01).residual(NEAR) - p.residual(NEAR)
    np.testing.assert_allclose(moved[7], 0.01)
    assert np.count_nonzero(moved) == 1
    with pytest.raises(IndexError):
        p.shifted(7, 1, 0.01)


def test_bearings_unwrapped_across_a_turn_are_taken_in_parts_too():
    own = straight(60, heading=0.0, start=(-9e3, 0.0))
    away = np.array([0.0, -7e3]) - own
    turns = np.where(np.arange(60) < 12, 4.0 * np.pi, 0.0)  # beyond 2 pi in a fifth of them
    bearing = np.arctan2(away[:, 1], away[:, 0]) + turns
    p = BearingProblem(bearing, own, 1e-3)
    found = ExtendedKalman(reuse_start=True).estimate(p)
    assert np.linalg.norm(found.theta - [0.0, -7e3]) < 5.0


# -- bad input ---------------------------------------------------------------------------

TAKERS = [
    LeastSquares(),
    Irls(StudentT(4.0)),
    ExtendedKalman(),
    RecursiveTls(),
    TotalLeastSquares(),
]


def straight(n=50, heading=0.0, start=(0.0, 0.0), step=300.0):
    k = np.arange(float(n))
    return np.array(start) + step * k[:, None] * [np.cos(heading), np.sin(heading)]


def seen(own, emitter, sigma=2e-3, seed=3, noise=1.0):
    away = np.asarray(emitter) - own
    errors = noise * sigma * np.random.default_rng(seed).standard_normal(len(own))
    return BearingProblem(np.arctan2(away[:, 1], away[:, 0]) + errors, own, sigma)


@pytest.mark.parametrize("estimator", TAKERS, ids=lambda e: type(e).__name__)
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_ship_that_stays_or_heads_for_the_emitter_is_told_why(estimator, noise):
    heading = np.deg2rad(30.0)
    target = 2e4 * np.array([np.cos(heading), np.sin(heading)])
    for own in (straight(step=0.0, start=(10.0, 5.0)), straight(heading=heading)):
        with pytest.raises(UnobservableError, match="must move across the line of sight"):
            estimator.estimate(seen(own, target, noise=noise))


@pytest.mark.parametrize("estimator", TAKERS, ids=lambda e: type(e).__name__)
def test_an_emitter_on_the_track_is_refused(estimator):
    # flown over: the bearing turns by half a turn, the line of sight does not
    with pytest.raises(UnobservableError, match="must move across"):
        estimator.estimate(seen(straight(), (7_350.0, 0.0)))


@pytest.mark.parametrize("estimator", TAKERS, ids=lambda e: type(e).__name__)
def test_one_bearing_is_refused(estimator):
    with pytest.raises(UnobservableError, match="1 equations for 2 unknowns"):
        estimator.estimate(seen(straight(n=1), (5e3, 1e4)))


def test_an_emitter_too_far_to_tell_is_refused_unless_a_prior_tells():
    p = seen(straight(), (0.0, 5e7))
    with pytest.raises(UnobservableError, match=r"Moving along .*emitter\.y"):
        LeastSquares().estimate(p)
    prior = GaussianPrior.from_sd(np.array([1e4, 1e4]), np.array([0.0, 4e4]))
    found = LeastSquares().estimate(p, prior)
    # on a line of sight, about where the prior has it
    assert found.sd[1] > 0.5e4 > 10.0 * found.sd[0]


def test_circling_the_emitter_is_fine():
    turn = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    own = 5e3 * np.stack([np.cos(turn), np.sin(turn)], axis=1) + [100.0, 0.0]
    p = seen(own, (100.0, 0.0))
    assert np.linalg.norm(LeastSquares().estimate(p).theta - [100.0, 0.0]) < 10.0


def test_a_position_on_the_track_cannot_be_linearised():
    p = problem()
    with pytest.raises(InvalidInputError, match="own position 4, on the track"):
        p.linearise(p.own_position[4])


def test_bad_arrays_are_refused():
    own = straight()
    good = seen(own, (5e3, 1e4)).bearing
    spoiled = good.copy()
    spoiled[3] = np.nan
    with pytest.raises(InvalidInputError, match=r"bearing\[3\] is nan"):
        BearingProblem(spoiled, own, 1e-3)
    with pytest.raises(InvalidInputError, match="degrees"):
        BearingProblem(np.rad2deg(good), own, 1e-3)
    with pytest.raises(InvalidInputError, match="degrees"):
        BearingProblem(good, own, 5.0)
    with pytest.raises(InvalidInputError, match="own_position has shape"):
        BearingProblem(good, own[:-1], 1e-3)
    with pytest.raises(InvalidInputError, match="sigma has shape"):
        BearingProblem(good, own, np.full(2, 1e-3))
    with pytest.raises(InvalidInputError, match="spread"):
        BearingProblem(good, own, 1e-3).lines(-5.0)
    with pytest.raises(InvalidInputError, match="no bearing"):
        BearingProblem(good[:0], own[:0], 1e-3)
    with pytest.raises(InvalidInputError, match="sigma"):
        BearingProblem(good, own, np.where(np.arange(50) == 2, 0.0, 1e-3))
