"""What all draws share: of constants, of whole paths, scan by scan."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import GaussianPrior, Posterior, arviz_adapter
from probreg.motion.trajectory import Trajectory
from probreg.noise import Gaussian, StudentT
from probreg.posterior import PathPosterior
from probreg.samplers import BaseDraws, Exact, Importance, MetropolisHastings, Nuts
from probreg.samplers.moves import LocalGaussian
from probreg.samplers.paths import ExactPath, GibbsPath, MetropolisPath, NutsPath, PathDraws
from probreg.samplers.scans import (
    AccumulatedMemory,
    Flat,
    GaussianMemory,
    ParticleFilter,
    ScanMetropolis,
    Track,
)
from tests.conftest import linear_problem
from tests.motion.test_trajectory import make


def rng(seed=4):
    return np.random.default_rng(seed)


def model(T=7, time=True):
    states = ("target.x", "target.heading", "sensor.x")
    return dataclasses.replace(
        make(T=T), time=10.0 * np.arange(T) if time else None, names=states, units=("m", "rad", "m")
    )


def constants():
    problem = dataclasses.replace(linear_problem(1).problem, units=("m", "rad", "m", ""))
    posterior = Posterior(problem, Gaussian(), GaussianPrior.from_sd(np.full(4, 3.0)))
    draws = Exact().sample(posterior, 400, 4, rng())
    return draws, draws.theta.reshape(-1, 4), draws.theta.reshape(-1, 4).mean(axis=0), 1


def paths():
    draws = ExactPath().sample(PathPosterior(model(), Gaussian()), 400, 4, rng())
    flat = draws.path.reshape(-1, 7, 3)
    return draws, flat, flat.mean(axis=0), 0


def track():
    found = ScanMetropolis(AccumulatedMemory()).track(model(), rng())
    return found, np.swapaxes(found.draws, 0, 1), found.estimate, 1


@pytest.mark.parametrize("make_draws", [constants, paths, track], ids=lambda f: f.__name__)
def test_names_moments_table_print_and_arviz_are_those_of_the_draws(make_draws):
    draws, flat, mean, ddof = make_draws()
    assert isinstance(draws, BaseDraws)
    np.testing.assert_allclose(draws.mean, mean)
    np.testing.assert_allclose(draws.sd, flat.std(axis=0, ddof=ddof))
    ends = np.moveaxis(np.quantile(flat, [0.1, 0.9], axis=0), 0, -1)
    np.testing.assert_allclose(draws.interval(0.8), ends)
    table = draws.summary(0.8)
    np.testing.assert_allclose(table["mean"], np.ravel(mean))
    np.testing.assert_allclose(table[["10%", "90%"]], ends.reshape(-1, 2))
    assert list(table["unit"]) == list(draws.units) * (len(draws.scans) or 1)
    assert table.attrs["sampler"] == draws.sampler
    assert table.attrs["warnings"] == draws.warnings
    # angles are printed in milliradians, scans by their times
    turned = draws.units.index("rad")
    line = next(line for line in str(draws).splitlines() if line.startswith(draws.names[turned]))
    shown = float(line.split(" +- ")[0].split()[-1])
    assert shown == pytest.approx(1e3 * mean.reshape(-1, len(draws.names))[0, turned], abs=1e-4)
    assert "mrad" in line
    if draws.scans:
        assert table.index[1] == ("0 s", draws.names[1])
        assert table.loc[("60 s", draws.names[2]), "mean"] == mean[6, 2]
        assert all(f"at {when} s" in str(draws) for when in (0, 30, 60))
    data = draws.to_arviz()["posterior"]
    kept = next(iter(data.data_vars.values())).values
    assert kept.shape[0] * kept.shape[1] == len(flat)


def test_scans_without_times_go_by_number():
    draws = ExactPath().sample(PathPosterior(model(time=False), Gaussian()), 10, 2, rng())
    assert draws.scans[3] == "scan 3"
    assert "target.x at scan 0" in str(draws)


# -- mixing of paths -----------------------------------------------------------------------


def test_a_path_sampler_that_has_mixed_says_nothing():
    law = StudentT(4.0)
    for sampler, size in ((GibbsPath(), (1000, 4)), (MetropolisPath(), (200, 64))):
        draws = sampler.sample(PathPosterior(model(), law), *size, rng())
        assert draws.warnings == ()
        assert "warning" not in str(draws)


def test_a_path_sampler_that_has_not_mixed_names_state_and_time():
    posterior = PathPosterior(model(), StudentT(4.0))
    draws = MetropolisPath(warmup=0, block=1).sample(posterior, 12, 4, rng())
    said = draws.warnings
    assert len(said) == 2
    worst = int(np.nanargmax(draws.convergence.r_hat))
    where = f"{draws.names[worst % 3]} at {draws.scans[worst // 3]}"
    assert said[0].startswith(f"R-hat is {draws.convergence.r_hat[worst]:.3f} for {where} (")
    assert "effective draws" in said[1]
    assert str(draws).splitlines()[0] == f"warning: {said[0]}"


def test_one_state_that_has_not_mixed_is_found_among_mixed_ones():
    draws = ExactPath().sample(PathPosterior(model(), Gaussian()), 500, 4, rng())
    path = draws.path.copy()
    path[0, :, 5, 2] += 3.0 * draws.sd[5, 2]
    bad = dataclasses.replace(draws, path=path)
    assert draws.warnings == ()
    assert "for sensor.x at 50 s (1 of 21 are too large)" in bad.warnings[0]


def test_many_short_chains_are_not_blamed_for_chance():
    # 60 chains of 20 independent draws, 21 quantities: one alarm in a hundred runs; two or more
    # in 10 runs by chance: 4e-3
    posterior = PathPosterior(model(), Gaussian())
    runs = [ExactPath().sample(posterior, 20, 60, rng(s)) for s in range(10)]
    assert sum(bool(draws.warnings) for draws in runs) < 2
    # negative controls: the usual limit blames every run; one chain apart is seen
    assert all(draws.convergence.r_hat.max() > 1.01 for draws in runs)
    path = runs[0].path.copy()
    path[:6, :, 2, 0] += 4.0 * runs[0].sd[2, 0]
    assert "target.x at 20 s" in dataclasses.replace(runs[0], path=path).warnings[0]


def long_path(T=4000, chains=4, draws=300):
    one = np.ones((T, 1, 1))
    prior = GaussianPrior.from_sd(np.array([2.0]))
    scene = Trajectory(np.zeros((T, 1)), one, one, one[:-1], one[:-1], prior)
    path = rng().normal(size=(chains, draws, T, 1))
    return PathDraws(PathPosterior(scene, Gaussian()), path, sampler="independent")


def test_of_very_long_paths_some_scans_are_looked_at_the_last_among_them():
    draws = long_path()
    assert draws.warnings == ()
    path = draws.path.copy()
    path[0, :, -1] += 3.0
    said = dataclasses.replace(draws, path=path).warnings
    assert "state[0] at scan 3999 (1 of 300 are too large)" in said[0]


def test_chains_that_never_move_count_for_none():
    draws = long_path(T=5, chains=1)
    assert draws.warnings[0].startswith("one chain")
    still = dataclasses.replace(draws, path=np.ones_like(draws.path))
    assert "only 0 effective draws (bulk or tail) for state[0] at scan 0" in still.warnings[1]
    stuck = np.broadcast_to(np.arange(3.0)[:, None, None, None], (3, 20, 5, 1))
    assert "R-hat" in dataclasses.replace(draws, path=stuck).warnings[0]


def test_factors_on_the_process_noise_are_looked_at_too():
    draws = long_path(T=5)
    factors = 1.0 + 0.1 * rng(5).normal(size=(4, 300, 2))
    good = dataclasses.replace(draws, step_scale=factors)
    assert good.warnings == ()
    assert "step_scale[1]" in str(good)
    factors[0, :, 1] += 1.0
    bad = dataclasses.replace(draws, step_scale=factors)
    assert "for step_scale[1] (1 of 7" in bad.warnings[0]


def test_what_the_run_says_of_itself_is_said_of_paths_too():
    draws = long_path(T=5)
    sharp = dataclasses.replace(draws, gamma=2.0, facts={"pareto_k": 0.9})
    assert "gamma = 2" in sharp.warnings[0]
    assert "Pareto k is 0.90" in sharp.warnings[1]
    assert "not a posterior" in sharp.summary().columns
    few = dataclasses.replace(draws, path=draws.path[:, :3])
    assert few.warnings == ("too few draws a chain to judge convergence.",)


def test_nuts_that_diverges_says_so():
    posterior = PathPosterior(model(), Gaussian())
    wild = NutsPath(Nuts(warmup=5, target_accept=0.1)).sample(posterior, 20, 2, rng())
    count = int(wild.stats["diverging"].sum())
    assert count > 0
    assert f"{count} divergent transitions" in wild.warnings[-1]
    tame = NutsPath(Nuts(warmup=150)).sample(posterior, 20, 2, rng())
    assert not any("divergent" in text for text in tame.warnings)


# -- constants and tracks --------------------------------------------------------------------


def test_of_few_draws_the_importance_weights_are_said_nevertheless():
    problem = linear_problem(3, n=3, m=2, p=2, noise=1.0).problem
    posterior = Posterior(problem, StudentT(0.6), GaussianPrior.from_sd(np.full(2, 1e3)))
    found = Importance(df=1000.0).sample(posterior, 2, 400, rng())
    assert "too few draws" in found.warnings[0]
    assert "Pareto k" in found.warnings[1]


def test_one_chain_is_said():
    posterior = Posterior(linear_problem(1).problem, Gaussian())
    walk = MetropolisHastings((LocalGaussian(),))
    assert walk.sample(posterior, 50, 1, rng()).warnings[0].startswith("one chain")


def test_a_track_of_enough_draws_says_nothing():
    chain = ScanMetropolis(AccumulatedMemory(), steps=4000)
    for tracker in (chain, ParticleFilter(StudentT(4.0))):
        assert tracker.track(model(60), rng()).warnings == ()
    # under Gaussian noise three particles are the Kalman filter
    assert ParticleFilter(Gaussian(), 3).track(model(), rng()).warnings == ()


@pytest.mark.parametrize(
    ("tracker", "text"),
    [
        (ScanMetropolis(GaussianMemory(), step=1e-2), "have fewer than 50 effective draws"),
        (ScanMetropolis(GaussianMemory(), step=1e3), "% of proposals accepted"),
        (ScanMetropolis(GaussianMemory(), steps=60, burn_in=10), "effective draws"),
        (ParticleFilter(StudentT(4.0), 20), "of 60 scans have fewer than 50"),
        (ScanMetropolis(Flat(), gamma=10.0), "not the posterior"),
        (ScanMetropolis(Flat(), box=3.0), "edge of the box"),
        (ScanMetropolis(GaussianMemory(), steps=13, burn_in=10), "too few draws a scan"),
    ],
    ids=str,
)
def test_a_track_that_is_not_to_be_trusted_says_so(tracker, text):
    found = tracker.track(model(60), rng())
    assert any(text in said for said in found.warnings)
    assert isinstance(found, Track)
    assert str(found).startswith("warning: ")


def test_effective_draws_of_a_track_are_those_of_its_chains():
    found = ScanMetropolis(AccumulatedMemory()).track(model(), rng())
    expected = [
        min(arviz_adapter.ess(found.draws[t, :, k][None]) for k in range(3)) for t in (0, 6)
    ]
    np.testing.assert_allclose(found.effective(np.array([0, 6])), expected)
    assert list(found.summary()["acceptance"][::3]) == list(found.facts["acceptance"])
    particles = ParticleFilter(StudentT(4.0), 30).track(model(), rng())
    np.testing.assert_array_equal(particles.effective(), particles.facts["effective"])
