"""Filter, smoother and simulation smoother against dense algebra and another library."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import linalg, stats

from probreg import GaussianPrior, LinearProblem
from probreg.errors import InvalidInputError
from probreg.estimators import LeastSquares
from probreg.motion.dynamics import Constant, LinearGaussian, RandomWalk
from probreg.motion.trajectory import Trajectory
from probreg.numerics import kalman
from probreg.problems import as_rows, as_trajectory
from tests.conftest import linear_problem, random_covariances


def make(T=7, m=2, d=3, seed=1, singular=False):
    rng = np.random.default_rng(seed)
    F = np.eye(d) + 0.3 * rng.normal(size=(T - 1, d, d))
    Q = random_covariances(rng, T - 1, d)
    if singular:
        Q[:, 0, :] = Q[:, :, 0] = 0.0
    prior = GaussianPrior(rng.normal(size=d), random_covariances(rng, 1, d)[0])
    H, R = rng.normal(size=(T, m, d)), random_covariances(rng, T, m)
    return Trajectory(rng.normal(size=(T, m)) * 3.0, H, R, F, Q, prior)


def dense(model):
    """Joint mean and covariance of the path given all rows, and the rows' log-density."""
    T, d = len(model), model.H.shape[2]
    mean, covariance = np.zeros((T, d)), np.zeros((T, d, T, d))
    mean[0], covariance[0, :, 0] = model.prior.mean, model.prior.covariance
    for t in range(1, T):
        F = model.F[t - 1]
        mean[t] = F @ mean[t - 1]
        for s in range(t):
            covariance[t, :, s] = F @ covariance[t - 1, :, s]
            covariance[s, :, t] = covariance[t, :, s].T
        covariance[t, :, t] = F @ covariance[t - 1, :, t - 1] @ F.T + model.Q[t - 1]
    S, mu = covariance.reshape(T * d, T * d), mean.ravel()
    H = linalg.block_diag(*model.H)
    R = linalg.block_diag(*(block for scan in model.blocks for block in scan))
    keep = model.present.ravel() > 0.0
    H, R, y = H[keep], R[np.ix_(keep, keep)], model.y.ravel()[keep]
    spread = H @ S @ H.T + R
    gain = S @ H.T @ np.linalg.inv(spread)
    log_density = stats.multivariate_normal(H @ mu, spread).logpdf(y)
    return (mu + gain @ (y - H @ mu)).reshape(T, d), S - gain @ H @ S, log_density


@pytest.mark.parametrize("singular", [False, True])
def test_smoother_is_the_dense_conditional(singular):
    model = make(singular=singular)
    mean, covariance, log_density = dense(model)
    filtered, smoothed = model.filter(), model.smooth()
    np.testing.assert_allclose(smoothed.mean, mean, atol=1e-9)
    d = mean.shape[1]
    for t in range(len(model)):
        own = slice(d * t, d * t + d)
        np.testing.assert_allclose(smoothed.covariance[t], covariance[own, own], atol=1e-9)
        if t + 1 < len(model):
            following = slice(d * t + d, d * t + 2 * d)
            np.testing.assert_allclose(smoothed.cross[t], covariance[own, following], atol=1e-9)
    assert filtered.log_likelihood == pytest.approx(log_density, rel=1e-10)


def test_filter_is_the_dense_conditional_of_each_prefix():
    model = make()
    filtered = model.filter()
    for T in range(1, 8):
        part = dataclasses.replace(
            model, y=model.y[:T], H=model.H[:T], R=model.R[:T], F=model.F[: T - 1],
            Q=model.Q[: T - 1], present=model.present[:T],
        )  # fmt: skip
        np.testing.assert_allclose(filtered.mean[T - 1], dense(part)[0][-1], atol=1e-9)


def test_components_that_were_not_reported_do_not_count():
    model = make()
    present = np.ones((7, 2))
    present[2], present[4, 1] = 0.0, 0.0
    R = model.R.copy()
    R[4] = np.diag(np.diag(R[4]))
    gaps = dataclasses.replace(model, present=present, R=R)
    mean, _, _ = dense(gaps)
    np.testing.assert_allclose(gaps.smooth().mean, mean, atol=1e-9)


def test_smoother_is_that_of_another_library():
    from statsmodels.tsa.statespace.kalman_smoother import KalmanSmoother

    model = make(T=30)
    other = KalmanSmoother(k_endog=2, k_states=3)
    other.bind(np.asfortranarray(model.y.T))
    pad = [np.concatenate([a, a[-1:]]) for a in (model.F, model.Q)]
    other["design"], other["obs_cov"] = np.moveaxis(model.H, 0, -1), np.moveaxis(model.R, 0, -1)
    other["transition"], other["state_cov"] = (np.moveaxis(a, 0, -1) for a in pad)
    other["selection"] = np.eye(3)
    other.initialize_known(model.prior.mean, model.prior.covariance)
    found = other.smooth()
    smoothed, filtered = model.smooth(), model.filter()
    np.testing.assert_allclose(smoothed.mean, found.smoothed_state.T, atol=1e-8)
    np.testing.assert_allclose(
        smoothed.covariance, np.moveaxis(found.smoothed_state_cov, -1, 0), atol=1e-8
    )
    np.testing.assert_allclose(filtered.mean, found.filtered_state.T, atol=1e-8)
    assert filtered.log_likelihood == pytest.approx(found.llf, rel=1e-10)


@pytest.mark.parametrize("singular", [False, True])
def test_simulation_smoother_has_the_dense_moments(singular):
    # 40 000 draws: 21 means and 231 covariances at 5 standard errors, false-alarm rate 1.5e-4
    model = make(singular=singular)
    mean, covariance, _ = dense(model)
    paths = model.draw(np.random.default_rng(3), 40_000).reshape(40_000, -1)
    sd = np.sqrt(np.diag(covariance))
    assert (np.abs(paths.mean(axis=0) - mean.ravel()) < 5.0 * sd / 200.0).all()
    error = np.sqrt((covariance**2 + np.outer(sd**2, sd**2)) / 40_000)
    assert (np.abs(np.cov(paths.T) - covariance) < 5.0 * error + 1e-12).all()


def test_a_wrong_gain_is_seen():
    # negative control: paths drawn without looking at the scan ahead
    model = make()
    _, covariance, _ = dense(model)
    filtered = model.filter()
    rng = np.random.default_rng(3)
    roots = np.array([kalman.semidefinite_root(P) for P in filtered.covariance])
    z = rng.standard_normal((40_000, *filtered.mean.shape))
    paths = (filtered.mean + np.einsum("tab,ntb->nta", roots, z)).reshape(40_000, -1)
    sd = np.sqrt(np.diag(covariance))
    error = np.sqrt((covariance**2 + np.outer(sd**2, sd**2)) / 40_000)
    assert (np.abs(np.cov(paths.T) - covariance) > 5.0 * error).any()


def test_a_constant_bias_is_batch_least_squares():
    problem, _ = linear_problem(3, n=40)
    prior = GaussianPrior.from_sd(np.full(4, 5.0))
    timed = LinearProblem(problem.y, problem.B, problem.R, np.arange(40) // 3.0)
    model = as_trajectory(timed, Constant(), prior)
    assert len(model) == 14
    batch = LeastSquares().estimate(problem, prior)
    smoothed = model.smooth()
    for t in (0, 7, 13):
        np.testing.assert_allclose(smoothed.mean[t], batch.theta, atol=1e-8)
        np.testing.assert_allclose(smoothed.covariance[t], batch.covariance, atol=1e-8)
    np.testing.assert_allclose(model.filter().mean[-1], batch.theta, atol=1e-8)


def test_gaps_in_time_are_longer_steps():
    problem, _ = linear_problem(4, n=5)
    times = np.array([0.0, 1.0, 2.0, 7.0, 8.0])
    timed = LinearProblem(problem.y, problem.B, problem.R, times)
    prior, rate = GaussianPrior.from_sd(np.full(4, 2.0)), np.array([0.1, 0.2, 0.3, 0.4])
    model = as_trajectory(timed, RandomWalk(rate), prior)
    np.testing.assert_allclose(model.Q[2], np.diag(5.0 * rate))
    steps = LinearGaussian(np.eye(4), np.diag(rate))
    other = as_trajectory(timed, steps, prior)
    np.testing.assert_allclose(other.smooth().mean, model.smooth().mean)
    with pytest.raises(InvalidInputError, match="no whole number of steps"):
        LinearGaussian(np.eye(4), np.diag(rate)).step(4, 1.5)
    F = np.array([[1.0, 1.0], [0.0, 1.0]])
    twice = LinearGaussian(F, np.eye(2)).step(2, 2.0)
    np.testing.assert_allclose(twice[0], F @ F)
    np.testing.assert_allclose(twice[1], F @ F.T + np.eye(2))


def test_weights_divide_the_variance():
    model = make()
    weights = np.random.default_rng(2).uniform(0.2, 3.0, (7, 2))
    R = model.R.copy()
    root = np.array([linalg.sqrtm(r) for r in R]).real
    scaled = root @ (np.eye(2) / weights[:, None, :]) @ root
    other = dataclasses.replace(model, R=scaled)
    np.testing.assert_allclose(model.filter(weights).mean, other.filter().mean, atol=1e-8)


def test_bad_input_is_refused():
    model = make()
    with pytest.raises(InvalidInputError, match="not positive semi-definite"):
        RandomWalk(np.array([1.0, -1.0]))
    with pytest.raises(InvalidInputError, match="not symmetric"):
        LinearGaussian(np.eye(2), np.array([[1.0, 0.5], [0.0, 1.0]]))
    with pytest.raises(InvalidInputError, match=r"Q\[0\] is not positive semi-definite"):
        dataclasses.replace(model, Q=-model.Q)
    with pytest.raises(InvalidInputError, match="time goes back after scan 2"):
        dataclasses.replace(model, time=np.array([0.0, 1.0, 2.0, 1.5, 4.0, 5.0, 6.0]))
    problem = linear_problem(1).problem
    with pytest.raises(InvalidInputError, match="needs the times"):
        as_trajectory(problem, Constant(), GaussianPrior.from_sd(np.ones(4)))
    with pytest.raises(InvalidInputError, match="moves 2 unknowns; the problem has 4"):
        RandomWalk(np.ones(2)).step(4, 1.0)
    y = model.y.copy()
    y[1, 0] = np.nan
    with pytest.raises(InvalidInputError, match=r"y\[1, 0\] is nan"):
        dataclasses.replace(model, y=y)
    with pytest.raises(InvalidInputError, match=r"Q has shape \(2, 2\)"):
        dataclasses.replace(model, Q=np.eye(2))
    assert RandomWalk(2.0).step(1, 3.0)[1] == 6.0
    with pytest.raises(InvalidInputError, match="present has shape"):
        dataclasses.replace(model, present=np.ones((7, 3)))


def test_compiled_code_is_the_same_code_in_plain_python(monkeypatch):
    model = make()
    quick = model.filter(), model.smooth(), model.draw(np.random.default_rng(1), 2)
    for name in (
        "semidefinite_root",
        "_gain",
        "run_filter",
        "run_smoother",
        "backward_map",
        "spread",
    ):
        monkeypatch.setattr(kalman, name, getattr(kalman, name).py_func)
    slow = model.filter(), model.smooth(), model.draw(np.random.default_rng(1), 2)
    np.testing.assert_allclose(slow[0].mean, quick[0].mean, rtol=1e-10)
    np.testing.assert_allclose(slow[1].covariance, quick[1].covariance, rtol=1e-8)
    np.testing.assert_allclose(slow[2], quick[2], rtol=1e-8)


def test_the_transposed_map_is_the_derivative():
    model = make()
    back = model.backward(model.filter())
    rng = np.random.default_rng(5)
    z, slope = rng.normal(size=(2, 3, 7, 3))
    pulled = back.pull_back(slope)
    along = ((back.paths(z) - back.mean) * slope).sum(axis=(1, 2))
    np.testing.assert_allclose((pulled * z).sum(axis=(1, 2)), along, rtol=1e-10)


def test_rows_of_a_scan_given_as_blocks_are_the_whole_matrix():
    rng = np.random.default_rng(3)
    blocks = random_covariances(rng, 14, 2).reshape(7, 2, 2, 2)
    whole = np.zeros((7, 4, 4))
    whole[:, :2, :2], whole[:, 2:, 2:] = blocks[:, 0], blocks[:, 1]
    model = make(m=4)
    one = dataclasses.replace(model, R=whole, width=2)
    two = dataclasses.replace(model, R=blocks, width=0)
    assert two.width == 2
    for a, b in zip(one.smooth(), two.smooth(), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-10)
    assert one.filter().log_likelihood == pytest.approx(two.filter().log_likelihood)
    timed = {"time": np.arange(7.0)}
    rows = [as_rows(dataclasses.replace(m, **timed)) for m in (one, two)]
    np.testing.assert_array_equal(rows[0].R, rows[1].R)


def test_a_crowded_scan_needs_no_matrix_of_its_whole_size():
    # 99 scans of one row and one of 2000: dense matrices would take 28 GB
    problem = linear_problem(4, 2099, 3, 2).problem
    time = np.concatenate([np.arange(99.0), np.full(2000, 99.0)])
    timed = dataclasses.replace(problem, time=time)
    prior = GaussianPrior.from_sd(np.full(2, 10.0))
    model = as_trajectory(timed, Constant(), prior)
    exact = LeastSquares().estimate(problem, prior)
    np.testing.assert_allclose(model.filter().mean[-1], exact.theta, rtol=1e-8)


def test_rows_say_which_components_are_real():
    model = dataclasses.replace(make(m=4), R=np.tile(np.eye(4), (7, 1, 1)), width=2,
                                time=np.arange(7.0))  # fmt: skip
    present = np.tile([True, True, False, True], (7, 1))
    problem = as_rows(dataclasses.replace(model, present=present))
    np.testing.assert_array_equal(problem.size, np.tile([2, 1], 7))
    np.testing.assert_array_equal(problem.y[1::2, 0], model.y[:, 3])
    np.testing.assert_array_equal(problem.B[1::2, 0], model.H[:, 3])
    assert not problem.y[1::2, 1].any()


def test_what_stands_where_nothing_was_reported_is_not_looked_at():
    model = make()
    present = np.tile([True, False], (7, 1))
    y, R = model.y.copy(), model.R.copy()
    y[:, 1], R[:, 1, 1] = np.nan, 0.0
    plain = dataclasses.replace(model, present=present).filter()
    odd = dataclasses.replace(model, y=y, R=R, present=present).filter()
    np.testing.assert_array_equal(plain.mean, odd.mean)


def test_a_prior_too_wide_for_double_precision_is_refused():
    # scalar rows of unit variance; at 1e4 the answer is right, at 1e8 rounding would decide
    rng = np.random.default_rng(6)
    H, one = rng.normal(size=(30, 1, 2)), np.ones((30, 1, 1))
    y = rng.normal(size=(30, 1))
    walk = [1e-4 * np.eye(2)] * 29
    right = Trajectory(y, H, one, np.eye(2), np.array(walk), GaussianPrior.from_sd(np.full(2, 1e4)))
    # by information: differences of the walk, the prior, the rows
    step = np.eye(60)[2:] - np.eye(60)[:-2]
    J = 1e4 * step.T @ step
    J[:2, :2] += 1e-8 * np.eye(2)
    rows = linalg.block_diag(*H)
    J += rows.T @ rows
    mean = np.linalg.solve(J, rows.T @ y.ravel()).reshape(30, 2)
    np.testing.assert_allclose(right.smooth().mean, mean, rtol=1e-5)
    np.testing.assert_allclose(right.smooth().covariance[0], np.linalg.inv(J)[:2, :2], rtol=1e-4)
    wide = dataclasses.replace(right, prior=GaussianPrior.from_sd(np.full(2, 1e8)))
    with pytest.raises(InvalidInputError, match="Give a narrower prior"):
        wide.filter()


@pytest.mark.parametrize(("change", "text"), [
    ({"present": np.full((7, 2), np.nan)}, "true or false"),
    ({"width": -1}, "no whole rows"),
    ({"units": ("m",)}, "names and units"),
    ({"R": np.ones((7, 2))}, "R has shape"),
], ids=str)  # fmt: skip
def test_more_bad_input_is_refused(change, text):
    with pytest.raises(InvalidInputError, match=text):
        dataclasses.replace(make(), **change)


def test_weights_are_checked():
    model = make()
    for weights, text in ((np.full((7, 2), np.nan), "non-finite"), (-np.ones((7, 2)), "negative"),
                          (np.ones((3, 2)), "shape")):  # fmt: skip
        with pytest.raises(InvalidInputError, match=text):
            model.filter(weights)
    with pytest.raises(InvalidInputError, match="interval"):
        RandomWalk(np.ones(2)).step(2, -1.0)
