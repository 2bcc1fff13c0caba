"""The posterior seen from torch and Pyro, which are loaded only when this is asked for."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import numpy as np

from probreg import extras
from probreg.noise import NoiseLaw
from probreg.posterior.density import Density
from probreg.prior import GaussianPrior, NoiseParameter
from probreg.typing import FloatArray

Slope = Callable[[FloatArray], tuple[Any, FloatArray]]


@cache
def _function() -> Any:
    """A torch function of a numpy density and its own gradient: torch never sees the rows."""
    import torch

    class NumpyDensity(torch.autograd.Function):
        """Value and gradient of one state (d,)."""

        @staticmethod
        def forward(ctx: Any, x: Any, function: Slope) -> Any:
            value, slope = function(x.detach().numpy())
            ctx.slope = torch.from_numpy(slope)
            return torch.tensor(float(value), dtype=torch.float64)

        @staticmethod
        def backward(ctx: Any, *outer: Any) -> Any:
            return outer[0] * ctx.slope, None

    return NumpyDensity


def as_torch(function: Slope) -> Callable[[Any], Any]:
    """Make a torch function of one that gives its value and gradient (d,) at (d,)."""
    wrapped = _function()
    return lambda x: wrapped.apply(x, function)


@contextmanager
def borrowed_torch(seed: int) -> Iterator[None]:
    """Seed torch, numpy and random, on one thread; leave all of them as they were found."""
    import pyro
    import torch

    states = torch.get_rng_state(), np.random.get_state(), random.getstate()  # noqa: NPY002
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    pyro.set_rng_seed(seed)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
        torch.set_rng_state(states[0])
        np.random.set_state(states[1])  # noqa: NPY002
        random.setstate(states[2])


def pyro_model(
    density: Density,
    prior: GaussianPrior | None,
    noise: NoiseLaw,
    noise_prior: tuple[NoiseParameter, ...],
) -> Callable[[], None]:
    """An ordinary Pyro model of a posterior density, its priors as sites of their own."""
    extras.require("nuts", "A Pyro model")
    import pyro
    import torch
    from pyro import distributions as dist

    rows = as_torch(density.likelihood_and_grad)
    p = density.dim - len(noise_prior)
    if prior is None:
        theta: Any = dist.ImproperUniform(dist.constraints.real_vector, (), (p,))
    else:
        mean, covariance = torch.tensor(prior.mean), torch.tensor(prior.covariance)
        theta = dist.MultivariateNormal(mean, covariance)

    def model() -> None:
        parts = [pyro.sample("theta", theta).double()]
        for parameter in noise_prior:
            name = f"noise.{parameter.name}"
            support = noise.supports[parameter.name]
            centre = torch.tensor(parameter.free_median(noise), dtype=torch.float64)
            free = pyro.sample(f"{name}.free", dist.Normal(centre, parameter.spread))
            natural = torch.sigmoid(free) if support.share else support.lower + torch.exp(free)
            pyro.deterministic(name, natural)
            parts.append(free.reshape(1))
        x = torch.cat(parts)
        if density.box is not None:
            inside = bool(density.inside(x.detach().numpy()))
            pyro.factor("box", torch.tensor(0.0 if inside else -np.inf, dtype=torch.float64))
        pyro.factor("rows", rows(x))

    return model
