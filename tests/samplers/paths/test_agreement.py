"""Gibbs, MH and NUTS on one data set: target and drifting bias under Student-t noise."""

from __future__ import annotations

import numpy as np
import pytest

from probreg import GaussianPrior, arviz_adapter
from probreg.motion.dynamics import RandomWalk
from probreg.motion.target_state import Target, follow_target
from probreg.noise import Gaussian, StudentT
from probreg.posterior.path_posterior import PathPosterior
from probreg.samplers import Nuts
from probreg.samplers.paths import ExactPath, GibbsPath, MetropolisPath, NutsPath
from probreg.scenarios.uturn import UturnScene, simulate

LAW = StudentT(4.0, scale=np.sqrt(0.5), componentwise=True)
STATES = [(t, k) for t in (0, 7, 14) for k in (0, 2, 4, 5)]


@pytest.fixture(scope="module")
def posterior():
    data, _ = simulate(UturnScene("pair", scans=15), np.random.default_rng(3))
    target = Target(np.array([-19_700.0, 0.0]), np.array([300.0, 0.0]))
    walk, prior = RandomWalk(np.full(2, 1000.0)), GaussianPrior.from_sd(np.full(2, 200.0))
    model = follow_target(data, target, {"sensor": (walk, prior)})
    return PathPosterior(model.simulate(LAW, np.random.default_rng(4))[1], LAW)


def moments(draws):
    """Means of states and of their squares about fixed values, with Monte-Carlo errors."""
    found = []
    for t, k in STATES:
        x = draws.path[:, :, t, k]
        centre = draws.posterior.reference.mean[t, k]
        for series in (x, (x - centre) ** 2):
            ess = arviz_adapter.ess(series, "mean")
            assert ess > 200, f"only {ess:.0f} effective draws"
            found.append((series.mean(), series.std() / np.sqrt(ess)))
    return np.array(found).T


@pytest.fixture(scope="module")
def gibbs(posterior):
    return moments(GibbsPath().sample(posterior, 6000, 2, np.random.default_rng(1)))


@pytest.mark.parametrize(
    ("sampler", "draws", "chains"),
    [(MetropolisPath(), 200, 60), (NutsPath(Nuts(warmup=200)), 600, 2)],
    ids=["MH", "NUTS"],
)
def test_samplers_agree(posterior, gibbs, sampler, draws, chains):
    # 24 differences of two independent estimates, each sampler at a false-alarm rate of 1e-4
    mean, error = moments(sampler.sample(posterior, draws, chains, np.random.default_rng(2)))
    assert np.abs((mean - gibbs[0]) / np.hypot(error, gibbs[1])).max() < 4.9


def test_the_gaussian_answer_is_told_apart(posterior, gibbs):
    # negative control: the smoother that takes the noise for Gaussian
    plain = PathPosterior(posterior.trajectory, Gaussian())
    draws = ExactPath().sample(plain, 6000, 2, np.random.default_rng(1)).path
    values = [draws[:, :, t, k] for t, k in STATES]
    means = np.array([v.mean() for v in values])
    errors = np.array([v.std() / np.sqrt(v.size) for v in values])
    z = (means - gibbs[0][::2]) / np.hypot(errors, gibbs[1][::2])
    assert np.abs(z).max() > 4.9
