"""Families of posteriors whose truth comes from the prior, and the samplers put to the test."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cache

import numpy as np

from probreg import (
    AssociatedReports,
    BearingProblem,
    BearingReports,
    GaussianPrior,
    LinearProblem,
    Posterior,
    Radar2D,
    Radar3D,
    ReportProblem,
)
from probreg.diagnostics import Case
from probreg.noise import Contaminated, Gaussian, Huber, Hyperbolic, NoiseLaw, StudentT
from probreg.prior import NoiseParameter
from probreg.samplers import Exact, Gibbs, Importance, MetropolisHastings, Nuts, Sampler
from probreg.samplers.moves import GlobalUniform, LocalGaussian
from probreg.scenarios.ralad import RaladScene
from probreg.scenarios.rekf import RekfScene
from probreg.typing import FloatArray

Unknown = tuple[NoiseParameter, ...]
LAWS: dict[str, tuple[NoiseLaw, Unknown]] = {
    "Gaussian": (Gaussian(), ()),
    "Laplace": (Hyperbolic(), ()),
    "Student-t": (StudentT(4.0), ()),
    "Student-t, by component": (StudentT(4.0, componentwise=True), ()),
    "contaminated": (Contaminated(0.1, 10.0), ()),
    "Huber": (Huber(1.345), ()),
    "Gaussian, scale unknown": (Gaussian(), (NoiseParameter("scale", 1.0, 0.3),)),
    "Student-t, nu and scale unknown": (
        StudentT(4.0),
        (NoiseParameter("nu", 5.0, 0.5), NoiseParameter("scale", 1.0, 0.3)),
    ),
    "contaminated, all unknown": (
        Contaminated(0.1, 10.0),
        (
            NoiseParameter("rate", 0.1, 0.5),
            NoiseParameter("scale", 8.0, 0.3),
            NoiseParameter("core_scale", 1.0, 0.2),
        ),
    ),
}


def samplers() -> dict[str, Sampler]:
    """Every sampler that advances many chains together; NUTS has a study of its own."""
    paper = (LocalGaussian(share=0.9), GlobalUniform(share=0.1))
    return {
        "Exact": Exact(),
        "MH": MetropolisHastings(warmup=20),
        "MH, local and global": MetropolisHastings(paper, warmup=60),
        "Gibbs": Gibbs(warmup=30),
        "importance": Importance(oversample=6.0),
    }


def applies(sampler: Sampler, noise: NoiseLaw, unknown: Unknown) -> bool:
    """Whether a sampler takes a law."""
    if isinstance(sampler, Exact):
        return isinstance(noise, Gaussian) and not unknown
    return noise.scale_mixture if isinstance(sampler, Gibbs) else True


def nuts() -> Nuts:
    """NUTS as it is put to the test: one chain, every third draw kept."""
    return Nuts(warmup=100)


@cache
def design(geometry: str, rows: int) -> LinearProblem:
    """Sensitivity and scale matrices of a pair of radars and targets that never change.

    "pair_2d": two 2-D radars 10 km apart; "pair_3d": the radars of the RALAD scene.
    """
    rng = np.random.default_rng(20260001)
    if geometry == "pair_2d":
        sensors: tuple[Radar2D, ...] | tuple[Radar3D, ...] = (
            Radar2D((0.0, 0.0), 30.0, np.deg2rad(0.3), "i"),
            Radar2D((10e3, 2e3), 50.0, np.deg2rad(0.5), "j", from_north=True),
        )
        targets = rng.uniform(-20e3, 20e3, (rows, 2))
    else:
        sensors = RaladScene().sensors
        targets = rng.uniform([-20e3, -20e3, 2e3], [20e3, 20e3, 3e3], (rows, 3))
    values = tuple(sensor.to_report(targets) for sensor in sensors)
    problem = ReportProblem(AssociatedReports(sensors, values))
    return problem.one_shot([(targets,) * 2])


@dataclass(frozen=True)
class LinearFamily:
    """Rows of a fixed design; truth from the prior, noise from the law."""

    geometry: str
    law: str
    rows: int = 100

    def __call__(self, rng: np.random.Generator) -> Case:
        """Draw one case."""
        problem, (noise, unknown) = design(self.geometry, self.rows), LAWS[self.law]
        prior = GaussianPrior.default(problem)
        theta, values = prior.sample(rng), {p.name: p.sample(rng, noise) for p in unknown}
        law = dataclasses.replace(noise, **values)  # type: ignore[type-var]
        n, m = problem.y.shape
        residual = (_roots(problem) @ law.sample(rng, n, m)[..., None])[..., 0]
        data = dataclasses.replace(problem, y=problem.B @ theta + residual)
        posterior = Posterior(data, noise, prior, unknown)
        return Case(posterior, posterior.free(np.array([*theta, *values.values()])))


def _roots(problem: LinearProblem) -> FloatArray:
    """Symmetric roots of the scale matrices, which component-wise laws depend on."""
    values, vectors = np.linalg.eigh(problem.R)
    roots: FloatArray = (vectors * np.sqrt(values)[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    return roots


@dataclass(frozen=True)
class ReportFamily:
    """The whole chain: polar reports of the RALAD radars, converted and re-linearised.

    Heavy tails stretch both reports of a row together, so that their contrast has the
    Student-t law to first order.
    """

    reports: int
    nu: float = float("inf")
    sd_range_m: float = 30.0
    sd_angle_deg: float = 0.3

    def __call__(self, rng: np.random.Generator) -> Case:
        """Draw one case."""
        sensors, n = RaladScene().sensors, self.reports
        sd = np.tile([self.sd_range_m, *np.deg2rad([self.sd_angle_deg] * 2)], 2)
        prior = GaussianPrior.from_sd(sd)
        theta = prior.sample(rng)
        targets = rng.uniform([-20e3, -20e3, 2e3], [20e3, 20e3, 3e3], (n, 3))
        heavy = np.isfinite(self.nu)
        stretch = np.sqrt(self.nu / rng.chisquare(self.nu, n)) if heavy else np.ones(n)
        values = tuple(
            sensor.to_report(targets) + own + stretch[:, None] * sensor.sample_noise(rng, n)
            for sensor, own in zip(sensors, theta.reshape(2, 3), strict=True)
        )
        problem = ReportProblem(AssociatedReports(sensors, values))
        return Case(Posterior(problem, StudentT(self.nu) if heavy else Gaussian(), prior), theta)


@dataclass(frozen=True)
class PositionFamily:
    """An emitter's position from the first bearings of the robust EKF paper's scene."""

    law: str
    bearings: int = 12
    sigma_deg: float = 1.0
    sd_m: float = 2_000.0

    def __call__(self, rng: np.random.Generator) -> Case:
        """Draw one case."""
        noise, _ = LAWS[self.law]
        scene = RekfScene(sigma_deg=self.sigma_deg)
        prior = GaussianPrior.from_sd(np.full(2, self.sd_m), np.array(scene.emitter_m))
        place = prior.sample(rng)
        own = scene.speed_m_s * np.arange(self.bearings)[:, None] * np.array([1.0, 0.0])
        sensor = scene.sensor
        error = sensor.sigma_bearing * noise.sample(rng, self.bearings, 1)[:, 0]
        bearing = sensor.to_report(np.broadcast_to(place, own.shape), own)[:, 0] + error
        problem = BearingProblem.of(BearingReports(sensor, bearing, own))
        return Case(Posterior(problem, noise, prior), place)
