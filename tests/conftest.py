"""Problems that many tests share. Truth travels beside data, never inside it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from probreg import (
    AssociatedReports,
    BearingReports,
    BearingSensor,
    LinearProblem,
    Radar2D,
    Radar3D,
    ReportProblem,
)
from probreg.scenarios.ralad import RaladScene, RaladTruth, simulate


class Linear(NamedTuple):
    problem: LinearProblem
    theta: np.ndarray


def random_covariances(rng: np.random.Generator, n: int, m: int) -> np.ndarray:
    root = rng.normal(size=(n, m, m)) + 2.0 * np.eye(m)
    return root @ np.swapaxes(root, 1, 2) + 0.5 * np.eye(m)


def symmetric_roots(R: np.ndarray) -> np.ndarray:
    """Symmetric square roots of covariances (..., m, m), by eigenvalues."""
    values, vectors = np.linalg.eigh(R)
    return (vectors * np.sqrt(values)[..., None, :]) @ np.swapaxes(vectors, -1, -2)


def linear_problem(seed: int, n: int = 60, m: int = 3, p: int = 4, noise: float = 1.0) -> Linear:
    """A linear problem with correlated rows and Gaussian noise `noise` times R."""
    rng = np.random.default_rng(seed)
    R = random_covariances(rng, n, m)
    B, theta = rng.normal(size=(n, m, p)), rng.normal(size=p)
    errors = np.linalg.cholesky(R) @ rng.normal(size=(n, m, 1))
    return Linear(LinearProblem(B @ theta + noise * errors[..., 0], B, R), theta)


def radar_pair(names: tuple[str, str] = ("i", "j")) -> tuple[Radar3D, Radar3D]:
    angle = np.deg2rad(0.2)
    return (
        Radar3D((-4000.0, -3000.0, 10.0), 25.0, angle, angle, name=names[0]),
        Radar3D((5000.0, 2000.0, 30.0), 35.0, 2.0 * angle, angle, name=names[1], from_north=True),
    )


def polar_reports(
    sensors: tuple, bias: np.ndarray, seed: int, n: int = 80, noise: float = 1.0
) -> AssociatedReports:
    """Reports of targets all around, entering as truth + bias + noise."""
    rng = np.random.default_rng(seed)
    dim = sensors[0].dim
    targets = rng.uniform(-20e3, 20e3, (n, dim))
    if dim == 3:
        targets[:, 2] = rng.uniform(500.0, 6000.0, n)
    values, start = [], 0
    for sensor in sensors:
        own = bias[start : start + len(sensor.bias_names)]
        start += len(own)
        values.append(sensor.to_report(targets) + own + noise * sensor.sample_noise(rng, n))
    return AssociatedReports(sensors, tuple(values), np.arange(n, dtype=float))


PAIR_BIAS = np.array([15.0, 4e-3, -3e-3, -25.0, 6e-3, 2e-3])


@pytest.fixture
def pair_problem() -> ReportProblem:
    return ReportProblem(polar_reports(radar_pair(), PAIR_BIAS, seed=5))


@pytest.fixture
def flat_pair() -> tuple[Radar2D, Radar2D]:
    return (
        Radar2D((0.0, 0.0), 20.0, 2e-3, name="a"),
        Radar2D((9000.0, 1000.0), 30.0, 3e-3, name="b", from_north=True),
    )


@pytest.fixture(scope="session")
def small_ralad() -> tuple[AssociatedReports, RaladTruth]:
    """Case 1 with a tenth of the scans, spread over the same flight."""
    scene = RaladScene().in_scans(80)
    return simulate(scene, np.random.default_rng(11))


EMITTER = np.array([5e3, 10e3])


def passive_reports(
    seed: int, n: int = 60, noise: float = 1.0, bias: float = 0.0, from_north: bool = False
) -> BearingReports:
    """Bearings of one emitter from an aircraft on a bent track."""
    rng = np.random.default_rng(seed)
    k = np.arange(float(n))
    own = np.stack([300.0 * k - 2e3, 800.0 * np.sin(k / 9.0)], axis=1)
    sensor = BearingSensor(np.deg2rad(0.2), from_north=from_north)
    errors = noise * sensor.sample_noise(rng, n)
    errors = -errors if from_north else errors
    bearing = sensor.to_report(np.broadcast_to(EMITTER, own.shape), own) + errors + bias
    return BearingReports(sensor, bearing, own, k)
