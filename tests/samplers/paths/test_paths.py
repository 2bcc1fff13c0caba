"""Path samplers: closed form, quadrature over three scans, agreement, calibration."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import probreg.samplers.paths
from probreg import GaussianPrior, arviz_adapter
from probreg.diagnostics import Ranks, binomial_limits
from probreg.discovery import public_classes
from probreg.errors import ImproperLawError, InvalidInputError
from probreg.motion.trajectory import Trajectory
from probreg.noise import Contaminated, Gaussian, HardReject, Huber, Hyperbolic, StudentT
from probreg.posterior.path_posterior import PathPosterior
from probreg.samplers import Nuts
from probreg.samplers.paths import ExactPath, GibbsPath, MetropolisPath, NutsPath, StepScale
from tests.conftest import symmetric_roots
from tests.judge import limit
from tests.motion.test_trajectory import dense, make

SAMPLERS = [cls() for cls in public_classes(probreg.samplers.paths).values()]
NAMED = {"argvalues": SAMPLERS, "ids": lambda s: type(s).__name__}
LAWS = [StudentT(3.0), Contaminated(0.2, 8.0), Hyperbolic(0.3), Huber(1.0)]


def rng(seed=3):
    return np.random.default_rng(seed)


def short(seed=2, T=3, outlier=8.0):
    """One drifting bias, three scans, the second of them wild."""
    generator = np.random.default_rng(seed)
    y = generator.normal(size=(T, 1))
    y[1] += outlier
    one = np.ones((T, 1, 1))
    prior = GaussianPrior.from_sd(np.array([2.0]))
    return Trajectory(y, one, one, one[:-1], 0.5 * one[:-1], prior)


def quadrature(model, noise, points=141):
    """Mean and variance of three scans of one state, on a grid of the path itself."""
    x = np.linspace(-9.0, 13.0, points)
    path = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1)
    log_prob = -0.5 * (path[..., 0] / 2.0) ** 2
    for t in (1, 2):
        log_prob = log_prob - 0.5 * (path[..., t] - path[..., t - 1]) ** 2 / 0.5
    for t in range(3):
        v = (model.y[t, 0] - x)[:, None]
        rows = noise.log_density(v)
        log_prob = log_prob + np.moveaxis(np.broadcast_to(rows, (points,) * 3), -1, t)
    weight = np.exp(log_prob - log_prob.max())
    weight /= weight.sum()
    mean = np.einsum("abc,abct->t", weight, path)
    return mean, np.einsum("abc,abct->t", weight, (path - mean) ** 2)


def scores(draws, mean, variance, least=150):
    found = []
    flat = draws.path.reshape(*draws.path.shape[:2], -1)
    for k, (m, s) in enumerate(zip(np.ravel(mean), np.ravel(variance), strict=True)):
        away = flat[..., k] - m
        for x, target in ((away, 0.0), (away**2, s)):
            ess = arviz_adapter.ess(x, "mean")
            assert ess >= least, f"only {ess:.0f} effective draws"
            found.append((x.mean() - target) / (x.std() / np.sqrt(ess)))
    return np.array(found)


def size(sampler):
    return (400, 2) if isinstance(sampler, NutsPath) else (1200, 16)


def test_discovery_finds_the_samplers():
    assert {"ExactPath", "GibbsPath", "MetropolisPath", "NutsPath"} == set(
        public_classes(probreg.samplers.paths)
    )


@pytest.mark.parametrize("sampler", **NAMED)
@pytest.mark.parametrize("singular", [False, True])
def test_gaussian_paths_have_the_dense_moments(sampler, singular):
    # 42 scores a case, family-wise false-alarm rate 1e-4
    model = make(singular=singular)
    mean, covariance, _ = dense(model)
    draws = sampler.sample(PathPosterior(model, Gaussian()), *size(sampler), rng())
    found = scores(draws, mean, np.diag(covariance))
    assert np.abs(found).max() < limit(found, 1e-4)


# NUTS is slow, so it meets one smooth law and one kinked one
QUICK = (StudentT, Huber)
CASES = [
    (s, law)
    for s in SAMPLERS[1:]
    for law in LAWS
    if not isinstance(s, NutsPath) or type(law) in QUICK
]


@pytest.mark.parametrize(("sampler", "law"), CASES, ids=lambda x: type(x).__name__)
def test_three_scans_agree_with_quadrature(sampler, law):
    # 6 scores in each of 11 cases, family-wise false-alarm rate 1e-3 over all of them
    posterior = PathPosterior(short(), law)
    if isinstance(sampler, GibbsPath) and not law.scale_mixture:
        with pytest.raises(InvalidInputError, match="not a Gaussian given"):
            sampler.sample(posterior, 5, 2, rng())
        return
    mean, variance = quadrature(posterior.trajectory, law)
    found = scores(sampler.sample(posterior, *size(sampler), rng()), mean, variance)
    assert np.abs(found).max() < limit(np.empty(66), 1e-3)
    # negative control: Gaussian noise gives another path
    plain = PathPosterior(short(), Gaussian())
    other = scores(ExactPath().sample(plain, 1200, 8, rng()), mean, variance)
    assert np.abs(other).max() > limit(np.empty(66), 1e-3)


def test_gradient_is_the_finite_difference():
    for law in (StudentT(3.0), StudentT(3.0, componentwise=True), Huber(1.0)):
        posterior = PathPosterior(make(), law)
        z = rng().normal(size=(1, *posterior.shape))
        _, gradient = posterior.log_prob_and_grad(z)
        for t, k in ((0, 0), (3, 1), (6, 2)):
            h = np.zeros_like(z)
            h[0, t, k] = 1e-5
            ends = [posterior.log_prob_and_grad(z + s * h)[0][0] for s in (1.0, -1.0)]
            assert gradient[0, t, k] == pytest.approx(
                (ends[0] - ends[1]) / 2e-5, rel=1e-5, abs=1e-7
            )


def test_density_is_that_of_the_path_up_to_a_constant():
    # in z: standard normal times ratio; on the path: prior times rows
    posterior = PathPosterior(short(), StudentT(3.0))
    z = rng().normal(size=(6, 3, 1))
    path = posterior.reference.paths(z)[..., 0]
    log_prior = -0.5 * (path[:, 0] / 2.0) ** 2 - ((path[:, 1:] - path[:, :-1]) ** 2).sum(axis=1)
    direct = log_prior + posterior.log_likelihood(path[..., None]).sum(axis=1)
    gap = posterior.log_prob_and_grad(z)[0] - direct
    np.testing.assert_allclose(gap, gap[0], atol=1e-9)


def test_rows_of_one_scan_keep_their_own_radius():
    # two rows of two components in a scan, under a law of whole rows
    model = make(m=4)
    R = model.R.copy()
    R[:, :2, 2:] = R[:, 2:, :2] = 0.0
    rows = PathPosterior(dataclasses.replace(model, R=R, width=2), StudentT(3.0))
    path = rng().normal(size=(7, 3))
    v = rows.residual(path)
    assert v.shape == (14, 2)
    np.testing.assert_allclose(rows.log_likelihood(path), StudentT(3.0).log_density(v))
    together = PathPosterior(dataclasses.replace(model, R=R), StudentT(3.0))
    assert together.residual(path).shape == (7, 4)
    with pytest.raises(InvalidInputError, match="no whole rows of 3"):
        dataclasses.replace(model, width=3)


@pytest.mark.parametrize("sampler", **NAMED)
def test_same_seed_same_paths(sampler):
    posterior = PathPosterior(make(), Gaussian())
    one, two = (sampler.sample(posterior, 6, 2, rng(1)) for _ in range(2))
    np.testing.assert_array_equal(one.path, two.path)
    assert one.path.shape == (2, 6, 7, 3)
    assert one.interval(0.9).shape == (7, 3, 2)
    assert one.to_arviz()["posterior"]["path"].shape == (2, 6, 7, 3)


@pytest.mark.parametrize("sampler", **NAMED)
def test_bad_numbers_are_refused(sampler):
    posterior = PathPosterior(make(), Gaussian())
    with pytest.raises(InvalidInputError, match="num_draws"):
        sampler.sample(posterior, 0, 2, rng())
    with pytest.raises(InvalidInputError, match="takes a PathPosterior"):
        sampler.sample(make(), 5, 2, rng())
    with pytest.raises(InvalidInputError, match="Generator"):
        sampler.sample(posterior, 5, 2, 3)


def test_improper_laws_and_wrong_paths_are_refused():
    with pytest.raises(ImproperLawError, match="no density"):
        PathPosterior(make(), HardReject(3.0))
    with pytest.raises(InvalidInputError, match="no closed form under StudentT"):
        ExactPath().sample(PathPosterior(make(), StudentT(3.0)), 5, 2, rng())
    with pytest.raises(InvalidInputError, match="its last axes must be"):
        PathPosterior(make(), Gaussian()).residual(np.zeros((6, 3)))


@pytest.mark.parametrize("sampler", [GibbsPath(warmup=20), MetropolisPath(warmup=200)], ids=repr)
def test_paths_are_calibrated(sampler):
    # truth from the prior, 150 runs of 8 scans, ranks of three scans among 49 draws; 1e-3
    law, generator = StudentT(4.0), rng(11)
    ranks = []
    for _ in range(150):
        model = make(T=8, d=2, seed=4)
        x = model.prior.sample(generator)
        truth, y = [], []
        for t in range(8):
            if t:
                step = np.linalg.cholesky(model.Q[t - 1]) @ generator.standard_normal(2)
                x = model.F[t - 1] @ x + step
            noise = symmetric_roots(model.R[t]) @ law.sample(generator, 1, 2)[0]
            truth.append(x)
            y.append(model.H[t] @ x + noise)
        data = dataclasses.replace(model, y=np.array(y))
        chains = 1 if isinstance(sampler, GibbsPath) else 49
        number = 3 if chains == 49 else 147
        draws = sampler.sample(PathPosterior(data, law), number, chains, generator)
        paths = np.swapaxes(draws.path, 0, 1).reshape(-1, 8, 2)[-1:-148:-3]
        ranks.append((paths < np.array(truth)).sum(axis=0)[[0, 4, 7]].ravel())
    p_values = Ranks(np.array(ranks), 49, tuple("abcdef")).p_values
    assert p_values.min() >= 1e-3 / 6


def test_settings_are_checked():
    for bad in (lambda: GibbsPath(warmup=-1), lambda: MetropolisPath(thin=0)):
        with pytest.raises(InvalidInputError, match="warmup"):
            bad()
    assert NutsPath(Nuts(warmup=10)).settings.warmup == 10


@pytest.mark.parametrize("law", [StudentT(4.0), StudentT(4.0, componentwise=True)], ids=repr)
def test_what_was_not_reported_does_not_count_wherever_it_stands(law):
    model = make(T=6)
    R = np.tile(np.eye(2), (6, 1, 1))
    present = np.tile([False, True], (6, 1))
    first = dataclasses.replace(model, R=R, present=present)
    swapped = dataclasses.replace(
        model, y=model.y[:, ::-1], H=model.H[:, ::-1], R=R, present=present[:, ::-1]
    )
    alone = dataclasses.replace(
        model, y=model.y[:, 1:], H=model.H[:, 1:], R=R[:, 1:, 1:], present=None, width=0
    )
    path = rng().normal(size=(6, 3))
    expected = PathPosterior(alone, law).log_likelihood(path)
    for other in (first, swapped):
        np.testing.assert_allclose(PathPosterior(other, law).log_likelihood(path), expected)
        assert other.filter().log_likelihood == pytest.approx(alone.filter().log_likelihood)


def test_nuts_needs_a_few_draws():
    with pytest.raises(InvalidInputError, match="at least 4 draws"):
        NutsPath().sample(PathPosterior(make(), Gaussian()), 2, 1, rng())


def test_small_blocks_leave_the_same_distribution():
    # 42 scores, family-wise 1e-4; blocks of two scans with edges at random
    model = make()
    mean, covariance, _ = dense(model)
    sampler = MetropolisPath(block=2)
    draws = sampler.sample(PathPosterior(model, Gaussian()), 1200, 16, rng())
    found = scores(draws, mean, np.diag(covariance))
    assert np.abs(found).max() < limit(found, 1e-4)


def step_scale_quadrature(model, scale, states):
    """Mean and variance of the log factor by quadrature over the marginal likelihood."""
    x = np.linspace(-6.0, 5.0, 400)
    on = np.array([float(name in states) for name in model.names])
    height = -0.5 * (x - np.log(scale.median)) ** 2 / scale.spread**2
    for k, factor in enumerate(np.exp(x[:, None] * on)):
        scaled = dataclasses.replace(model, Q=model.Q * np.outer(factor, factor))
        height[k] += dense(scaled)[2]
    weight = np.exp(height - height.max())
    weight /= weight.sum()
    mean = weight @ x
    return mean, weight @ (x - mean) ** 2


def test_unknown_process_noise_agrees_with_quadrature():
    # mean and mean square of the log factor, limit 4 standard errors
    scale = StepScale(("state[0]", "state[1]"), median=0.7, spread=0.8)
    model = make(T=6, d=2, seed=8)
    model = dataclasses.replace(model, Q=model.Q * 0.1)
    mean, variance = step_scale_quadrature(model, scale, scale.states)
    sampler = GibbsPath(unknown=(scale,))
    draws = sampler.sample(PathPosterior(model, Gaussian()), 1500, 4, rng())
    away = np.log(draws.step_scale[..., 0]) - mean
    for x, target in ((away, 0.0), (away**2, variance)):
        ess = arviz_adapter.ess(x, "mean")
        assert ess > 1000
        assert abs(x.mean() - target) < 4.0 * x.std() / np.sqrt(ess)
    assert draws.to_arviz()["posterior"]["step_scale"].shape == (4, 1500, 1)
    # negative control: the prior alone is another distribution
    assert abs(away.mean() + mean - np.log(0.7)) > 4.0 * away.std() / np.sqrt(1000)


def test_process_noise_is_found_under_student_noise():
    # 30 series of 80 scans with three times the assumed sd: 90 % intervals, limits at 1e-3
    law, one = StudentT(4.0), np.ones((80, 1, 1))
    prior = GaussianPrior.from_sd(np.array([2.0]))
    model = Trajectory(np.zeros((80, 1)), one, one, one[:-1], one[:-1], prior)
    sampler = GibbsPath(warmup=100, unknown=(StepScale(("state[0]",)),))
    held = 0
    for seed in range(30):
        factor = np.exp(rng(seed).normal())
        true = dataclasses.replace(model, Q=model.Q * factor**2)
        data = dataclasses.replace(true.simulate(law, rng(seed))[1], Q=model.Q)
        draws = sampler.sample(PathPosterior(data, law), 200, 1, rng(seed))
        low, high = np.quantile(draws.step_scale, [0.05, 0.95])
        held += low <= factor <= high
    low, high = binomial_limits(30, 0.9, 1e-3)
    assert low <= held / 30 <= high


def test_step_scales_are_checked():
    model = make()
    for scale, text in (
        (StepScale(("nothing",)), "no state"),
        (StepScale(("state[0]",)), "no process noise to scale"),
    ):
        data = dataclasses.replace(model, Q=0.0 * model.Q)
        with pytest.raises(InvalidInputError, match=text):
            GibbsPath(unknown=(scale,)).sample(PathPosterior(data, Gaussian()), 5, 1, rng())
    with pytest.raises(InvalidInputError, match="spread"):
        StepScale(("a",), spread=0.0)
