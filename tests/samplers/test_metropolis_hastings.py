"""Metropolis-Hastings: its moves, sharpening, the box; and broken copies that must fail."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import stats

from probreg import GaussianPrior, LinearProblem, Posterior
from probreg.errors import InvalidInputError
from probreg.noise import Gaussian, StudentT
from probreg.samplers import MetropolisHastings
from probreg.samplers.moves import GlobalUniform, LaplaceT, LocalGaussian
from tests.conftest import linear_problem
from tests.judge import limit, z_scores

PRIOR = GaussianPrior.from_sd(np.full(4, 3.0))


def rng(seed=2):
    return np.random.default_rng(seed)


def posterior(law=None):
    return Posterior(linear_problem(1).problem, law or Gaussian(), PRIOR)


def judged(sampler, target, gamma=1.0, draws=1200, chains=100, seed=2):
    """Moment scores against the closed form of a Gaussian posterior, at 50 000 effective draws."""
    found = sampler.sample(target, draws, chains, rng(seed))
    laplace = target.laplace
    return z_scores(found, laplace.mean, np.diag(laplace.covariance) / gamma, 50_000), found


MOVES = {
    "independent": (LaplaceT(),),
    "mixed": (LaplaceT(), LocalGaussian(), GlobalUniform()),
    "light tails": (LaplaceT(df=200.0),),
}


@pytest.mark.parametrize("name", MOVES)
def test_moments_of_a_gaussian_at_fifty_thousand_effective_draws(name):
    # 8 scores, family-wise false-alarm rate 1e-4 a case
    scores, _ = judged(MetropolisHastings(MOVES[name]), posterior(), draws=1500)
    assert np.abs(scores).max() < limit(scores, 1e-4)


@dataclass(frozen=True)
class TooWide:
    """A broken move: draws from one density, accepts by another."""

    share: float = 1.0
    stretch: float = 1.0

    def ready(self, target, gamma):
        density = LaplaceT(df=50.0).ready(target, gamma)
        # accepts as if the target were wider than it is
        object.__setattr__(density, "root", density.root * self.stretch)
        return density


@dataclass(frozen=True, eq=False)
class Broken:
    """A sampler whose draws are a right sampler's, changed."""

    change: object

    def sample(self, target, num_draws, num_chains, generator):
        found = MetropolisHastings().sample(target, num_draws, num_chains, generator)
        object.__setattr__(found, "theta", self.change(found.theta, target))
        return found


def test_an_error_of_scale_of_two_percent_is_seen():
    def stretched(theta, target):
        return target.laplace.mean + 1.02 * (theta - target.laplace.mean)

    scores, _ = judged(Broken(stretched), posterior())
    assert np.abs(scores).max() > limit(scores, 1e-4)
    right, _ = judged(Broken(lambda theta, target: theta), posterior())
    assert np.abs(right).max() < limit(right, 1e-4)


@dataclass(frozen=True)
class WithoutRatio:
    """A broken move: leaves the Hastings ratio out."""

    share: float = 1.0

    def ready(self, target, gamma):
        density = LaplaceT(df=3.0).ready(target, gamma)
        return _WithoutRatio(density)


@dataclass(frozen=True, eq=False)
class _WithoutRatio:
    density: object
    target: None = None

    def propose(self, x, step, generator):
        y, _ = self.density.propose(x, step, generator)
        return y, np.zeros(len(x))


def test_a_missing_hastings_ratio_is_seen():
    scores, _ = judged(MetropolisHastings((WithoutRatio(),)), posterior(), draws=2500)
    assert np.abs(scores).max() > limit(scores, 1e-4)


def cut_posterior():
    """One unknown, N(mean, sd^2) cut at the mean minus half an sd."""
    B, y = np.ones((10, 1, 1)), np.full((10, 1), 2.0)
    problem = LinearProblem(y, B, np.ones((10, 1, 1)))
    sd = 1.0 / np.sqrt(10.0)
    box = np.array([[2.0 - 0.5 * sd, np.inf]])
    expected = stats.truncnorm(-0.5, np.inf, 2.0, sd)
    return Posterior(problem, Gaussian(), box=box), expected


MOVES_AT_A_BOX = {
    "local": (LocalGaussian(),),
    "independent": (LaplaceT(),),
    "global": (GlobalUniform(),),
}


@pytest.mark.parametrize("name", MOVES_AT_A_BOX)
def test_at_a_box_states_repeat_and_moments_are_those_of_the_cut_normal(name):
    # 2 scores, family-wise false-alarm rate 1e-4 a case
    target, expected = cut_posterior()
    found = MetropolisHastings(MOVES_AT_A_BOX[name]).sample(target, 4000, 50, rng())
    scores = z_scores(found, [expected.mean()], [expected.var()], 15_000)
    assert np.abs(scores).max() < limit(scores, 1e-4)
    assert found.theta.min() >= target.box[0, 0]


def test_clipping_is_seen():
    target, expected = cut_posterior()
    free = Posterior(target.problem, Gaussian())
    low = target.box[0, 0]
    clipped = Broken(lambda theta, _: np.maximum(theta, low))
    found = clipped.sample(free, 1500, 50, rng())
    scores = z_scores(found, [expected.mean()], [expected.var()], 15_000)
    assert np.abs(scores).max() > limit(scores, 1e-4)


@pytest.mark.parametrize("gamma", [0.5, 4.0])
def test_sharpening_divides_the_covariance_and_says_that_it_is_no_posterior(gamma):
    sampler = MetropolisHastings(gamma=gamma)
    scores, found = judged(sampler, posterior(), gamma)
    assert np.abs(scores).max() < limit(scores, 1e-4)
    assert f"gamma = {gamma:g}" in found.warnings[0]
    assert "not the posterior" in str(found).splitlines()[0]
    table = found.summary()
    assert table["not a posterior"].eq(f"gamma = {gamma:g}").all()
    assert found.to_arviz()["posterior"].attrs["gamma"] == gamma


def test_steps_are_tuned_in_warm_up_only():
    sampler = MetropolisHastings((LocalGaussian(),), warmup=300)
    found = sampler.sample(posterior(StudentT(3.0)), 300, 32, rng())
    rate = found.facts["acceptance"]["LocalGaussian"]
    assert 0.2 < rate < 0.4
    fixed = MetropolisHastings((LocalGaussian(step=0.05),), warmup=300)
    assert fixed.sample(posterior(), 50, 8, rng()).facts["step"]["LocalGaussian"] == 1.0


def test_a_global_move_from_outside_its_box_is_not_taken():
    target = posterior()
    mode, sd = target.laplace.mean, np.sqrt(np.diag(target.laplace.covariance))
    box = np.stack([mode - 0.5 * sd, mode + 0.5 * sd], axis=1)
    moves = (GlobalUniform(box, share=0.5), LocalGaussian(share=0.5))
    # a box narrower than the posterior: reversible all the same
    scores, _ = judged(MetropolisHastings(moves), target, draws=12_000, chains=200)
    assert np.abs(scores).max() < limit(scores, 1e-4)


def test_settings_are_checked():
    with pytest.raises(InvalidInputError, match="gamma"):
        MetropolisHastings(gamma=0.0)
    with pytest.raises(InvalidInputError, match="at least one move"):
        MetropolisHastings(())
    with pytest.raises(InvalidInputError, match="step of LocalGaussian"):
        LocalGaussian(step=-1.0)
    with pytest.raises(InvalidInputError, match="share of LaplaceT"):
        LaplaceT(share=0.0)
    for box in (np.zeros((4, 2)), np.zeros((3, 2))):
        with pytest.raises(InvalidInputError, match="box of GlobalUniform"):
            MetropolisHastings((GlobalUniform(box),)).sample(posterior(), 5, 2, rng())
    away = np.tile([100.0, 101.0], (4, 1))
    with pytest.raises(InvalidInputError, match="excludes the mode"):
        MetropolisHastings((GlobalUniform(away),)).sample(posterior(), 5, 2, rng())


def test_a_density_that_is_not_finite_at_the_start_is_refused():
    problem = linear_problem(1).problem
    huge = LinearProblem(problem.y * 1e200, problem.B, problem.R)
    with pytest.raises(InvalidInputError, match="log-density at the mode is"):
        MetropolisHastings().sample(Posterior(huge, Gaussian(), PRIOR), 5, 2, rng())
