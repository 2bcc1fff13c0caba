"""Posterior moments of an independent package, stored for the tests.

    pip install numpyro
    python tests/reference/make_reference.py

writes `posteriors.npz` and its provenance `posteriors.json`. The models are written out
here in NumPyro's own distributions; nothing of probreg is used.
"""

from __future__ import annotations

import json
import platform
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import numpyro
import numpyro.distributions as dist
from numpyro.diagnostics import effective_sample_size
from numpyro.infer import MCMC, NUTS

HERE = Path(__file__).parent
DRAWS, CHAINS, WARMUP = 25_000, 4, 2_000


def student_problem() -> dict[str, np.ndarray]:
    """Four unknowns, 120 scalar rows, a tenth of them outliers."""
    rng = np.random.default_rng(41)
    B, theta = rng.normal(size=(120, 1, 4)), np.array([1.0, -0.5, 2.0, 0.3])
    noise = rng.standard_t(4.0, size=(120, 1))
    noise[rng.random(120) < 0.1] *= 10.0
    return {"y": (B @ theta) + noise, "B": B, "prior_sd": np.full(4, 5.0)}


def mixed_problem() -> dict[str, np.ndarray]:
    """Six unknowns, 80 rows of three components."""
    rng = np.random.default_rng(42)
    B, theta = rng.normal(size=(80, 3, 6)), np.array([1.0, -0.5, 2.0, 0.3, -1.2, 0.7])
    stretch = np.where(rng.random(80) < 0.15, 8.0, 1.0)
    noise = stretch[:, None] * rng.normal(size=(80, 3))
    return {"y": (B @ theta) + noise, "B": B, "prior_sd": np.full(6, 5.0)}


def student_model(y: np.ndarray, B: np.ndarray, prior_sd: np.ndarray) -> None:
    """Student-t rows with unknown nu and scale."""
    theta = numpyro.sample("theta", dist.Normal(0.0, prior_sd).to_event(1))
    nu = numpyro.sample("nu", dist.LogNormal(jnp.log(5.0), 0.5))
    scale = numpyro.sample("scale", dist.LogNormal(0.0, 0.5))
    numpyro.sample("y", dist.StudentT(nu, B[:, 0] @ theta, scale), obs=y[:, 0])


def mixed_model(y: np.ndarray, B: np.ndarray, prior_sd: np.ndarray) -> None:
    """Contaminated rows of three components, rate 0.1 and scale 10 known."""
    theta = numpyro.sample("theta", dist.Normal(0.0, prior_sd).to_event(1))
    mixing = dist.Categorical(probs=jnp.array([0.9, 0.1]))
    stretch = jnp.array([1.0, 10.0])
    rows = dist.Normal((B @ theta)[:, None, :], stretch[:, None]).to_event(1)
    numpyro.sample("y", dist.MixtureSameFamily(mixing, rows), obs=y)


def main() -> None:
    """Sample both posteriors and write their moments with Monte Carlo errors."""
    numpyro.enable_x64()
    arrays: dict[str, np.ndarray] = {}
    facts = {}
    for name, make, model in (
        ("student", student_problem, student_model),
        ("mixed", mixed_problem, mixed_model),
    ):
        data = make()
        run = MCMC(
            NUTS(model, dense_mass=True), num_warmup=WARMUP, num_samples=DRAWS, num_chains=CHAINS,
            chain_method="sequential", progress_bar=False,
        )  # fmt: skip
        run.run(jax.random.PRNGKey(7), **data)
        draws = run.get_samples(group_by_chain=True)
        parts = [np.asarray(draws["theta"])]
        parts += [np.asarray(draws[k])[..., None] for k in ("nu", "scale") if k in draws]
        x = np.concatenate(parts, axis=-1)
        ess = np.array([effective_sample_size(x[..., k]) for k in range(x.shape[-1])])
        square = (x - x.mean(axis=(0, 1))) ** 2
        ess_square = np.array([effective_sample_size(square[..., k]) for k in range(x.shape[-1])])
        arrays |= {f"{name}_{key}": value for key, value in data.items()}
        arrays[f"{name}_mean"], arrays[f"{name}_sd"] = x.mean(axis=(0, 1)), x.std(axis=(0, 1))
        arrays[f"{name}_mean_error"] = x.std(axis=(0, 1)) / np.sqrt(ess)
        arrays[f"{name}_variance_error"] = square.std(axis=(0, 1)) / np.sqrt(ess_square)
        facts[name] = {
            "least_ess": float(min(ess.min(), ess_square.min())),
            "draws": x[..., 0].size,
        }
    np.savez(HERE / "posteriors.npz", **arrays)
    provenance = {
        "package": "numpyro", "version": numpyro.__version__, "jax": jax.__version__,
        "python": platform.python_version(), "sampler": "NUTS, dense mass, float64",
        "warmup": WARMUP, "draws": DRAWS, "chains": CHAINS, "seed": 7,
        "made": time.strftime("%Y-%m-%d", time.gmtime()), "results": facts,
    }  # fmt: skip
    (HERE / "posteriors.json").write_text(json.dumps(provenance, indent=2) + "\n")


if __name__ == "__main__":
    main()
