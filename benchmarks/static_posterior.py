"""Time to 4000 effective draws of one posterior, ours and whichever peers are installed.

Run by `make benchmark`. Four unknowns, 400 scalar rows, Student-t(4) noise with a tenth of
outliers; flat but for a wide Gaussian prior. Times hold everything but imports: the mode and
the warm-up of ours, compilation of the peers apart where it can be told apart. Ours starts
from the mode and its curvature (that is its advantage and is disclosed here); peers run with
their recommended settings. Nothing is asserted.

    pip install numpyro blackjax emcee        # the peers, all optional
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from probreg import GaussianPrior, LinearProblem, Posterior, arviz_adapter
from probreg.noise import StudentT
from probreg.samplers import Gibbs, Importance, MetropolisHastings, Nuts, Sampler
from probreg.typing import FloatArray

NU, PRIOR_SD, TARGET = 4.0, 10.0, 4000


def make_data() -> tuple[FloatArray, FloatArray]:
    """y (400,) and B (400, 4)."""
    rng = np.random.default_rng(0)
    B, theta = rng.normal(size=(400, 4)), rng.normal(size=4)
    noise = rng.standard_t(NU, size=400)
    noise[rng.random(400) < 0.1] *= 10.0
    return B @ theta + noise, B


def fresh_posterior(y: FloatArray, B: FloatArray) -> Posterior:
    """A posterior with nothing cached: its mode is part of the time."""
    problem = LinearProblem(y[:, None], B[:, None, :], np.ones((400, 1, 1)))
    return Posterior(problem, StudentT(NU), GaussianPrior.from_sd(np.full(4, PRIOR_SD)))


def report(name: str, seconds: float, theta: FloatArray, base: float | None) -> float:
    """Print one line; returns the time to TARGET effective draws."""
    least = min(arviz_adapter.ess(theta[..., k]) for k in range(theta.shape[-1]))
    needed = seconds * TARGET / least
    ratio = "" if base is None else f"{needed / base:>10.0f}"
    line = f"{name:<26}{seconds:>9.3f}{least:>9.0f}{least / seconds:>10.0f}{needed:>12.3f}{ratio}"
    print(line, flush=True)
    return needed


def ours(y: FloatArray, B: FloatArray) -> float:
    """Our samplers; returns the time of Metropolis-Hastings, to which peers are compared."""
    settings: dict[str, tuple[Sampler, int, int]] = {
        "MH": (MetropolisHastings(), 300, 24),
        "Gibbs": (Gibbs(), 300, 24),
        "importance": (Importance(), 1000, 4),
        "NUTS (Pyro)": (Nuts(), 2000, 2),
    }
    base = 0.0
    for name, (sampler, draws, chains) in settings.items():
        sampler.sample(fresh_posterior(y, B), 10, 2, np.random.default_rng(1))  # imports
        runs = []
        for seed in range(3):
            began = time.perf_counter()
            found = sampler.sample(
                fresh_posterior(y, B), draws, chains, np.random.default_rng(seed)
            )
            runs.append((time.perf_counter() - began, found.theta))
        seconds, theta = sorted(runs, key=lambda run: run[0])[1]  # the median of three
        needed = report(name, seconds, theta, None)
        base = base or needed
    return base


def with_numpyro(y: FloatArray, B: FloatArray) -> Callable[[], tuple[float, FloatArray]]:
    """NUTS as its documentation has it; compiled in a first run."""
    import jax
    import numpyro
    import numpyro.distributions as dist
    from numpyro.infer import MCMC, NUTS

    numpyro.enable_x64()

    def model() -> None:
        theta = numpyro.sample("theta", dist.Normal(0.0, PRIOR_SD).expand([4]).to_event(1))
        numpyro.sample("y", dist.StudentT(NU, B @ theta, 1.0), obs=y)

    def run() -> tuple[float, FloatArray]:
        mcmc = MCMC(NUTS(model), num_warmup=1000, num_samples=1000, num_chains=4,
                    chain_method="sequential", progress_bar=False)  # fmt: skip
        began = time.perf_counter()
        mcmc.run(jax.random.PRNGKey(0))
        draws = np.asarray(mcmc.get_samples(group_by_chain=True)["theta"])
        return time.perf_counter() - began, draws

    return run


def with_blackjax(y: FloatArray, B: FloatArray) -> Callable[[], tuple[float, FloatArray]]:
    """NUTS after window adaptation, one chain, its loop compiled; the second run is timed."""
    import blackjax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    yj, Bj = jnp.asarray(y), jnp.asarray(B)

    def log_density(theta: object) -> object:
        left = yj - Bj @ theta
        rows = -0.5 * (NU + 1.0) * jnp.log1p(left**2 / NU)
        return rows.sum() - 0.5 * jnp.sum(theta**2) / PRIOR_SD**2

    @jax.jit
    def chain(key: object) -> object:
        first, second = jax.random.split(key)
        warm = blackjax.window_adaptation(blackjax.nuts, log_density)
        (state, parameters), _ = warm.run(first, jnp.zeros(4), num_steps=1000)
        step = blackjax.nuts(log_density, **parameters).step

        def one(state: object, key: object) -> tuple[object, object]:
            state, _ = step(key, state)
            return state, state.position

        return jax.lax.scan(one, state, jax.random.split(second, 4000))[1]

    def run() -> tuple[float, FloatArray]:
        began = time.perf_counter()
        draws = np.asarray(chain(jax.random.PRNGKey(0)))
        return time.perf_counter() - began, draws.reshape(4, 1000, 4)

    return run


def with_emcee(y: FloatArray, B: FloatArray) -> Callable[[], tuple[float, FloatArray]]:
    """The stretch move, 32 walkers, vectorised log-density, burnt in 500 steps."""
    import emcee

    def log_density(theta: FloatArray) -> FloatArray:
        left = y - theta @ B.T
        rows = -0.5 * (NU + 1.0) * np.log1p(left**2 / NU)
        return rows.sum(axis=-1) - 0.5 * np.sum(theta**2, axis=-1) / PRIOR_SD**2

    def run() -> tuple[float, FloatArray]:
        walkers = emcee.EnsembleSampler(32, 4, log_density, vectorize=True)
        start = np.random.default_rng(0).normal(size=(32, 4))
        began = time.perf_counter()
        walkers.run_mcmc(start, 5500)
        draws = walkers.get_chain(discard=500)
        return time.perf_counter() - began, np.swapaxes(draws, 0, 1)

    return run


PEERS = {"numpyro": with_numpyro, "blackjax": with_blackjax, "emcee": with_emcee}


def main() -> None:
    """Print the table."""
    y, B = make_data()
    print(f"{TARGET} bulk effective draws of 4 unknowns, 400 rows, Student-t({NU:g}); one thread")
    print(f"{'':<26}{'seconds':>9}{'ESS':>9}{'ESS/s':>10}{'s to 4000':>12}{'over MH':>10}")
    with threadpool_limits(1):
        base = ours(y, B)
        for name, make in PEERS.items():
            if importlib.util.find_spec(name) is None:
                print(f"{name:<26}not installed")
                continue
            run = make(y, B)
            first, _ = run()
            seconds, theta = run()
            report(f"{name} (compiled)", seconds, theta, base)
            report(f"{name} (first run)", first, theta, base)


if __name__ == "__main__":
    main()
