"""Small recordings in which everything is drawn from the prior of a track model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from probreg.motion.tracks import draw_model
from probreg.noise import Contaminated, StudentT
from probreg.noise._scale_mixture import WEAK
from probreg.noise.contaminated import RATE_ROWS
from probreg.posterior.tracks import Point, TrackModel
from probreg.posterior.tracks.accelerations import level_targets
from probreg.posterior.tracks.steps import CONSTANT_TARGETS, WRONG_ROWS
from probreg.prior import GaussianPrior
from probreg.problems.recording.sensor_model import SensorModel
from probreg.problems.recording.track_reports import PathPoints, TrackReports
from probreg.sensors.axes import PositionAxes
from tests.problems.test_track_reports import Constant

AREA_M2 = (400e3) ** 2
ABOUT = Contaminated(0.1, 10.0)


@dataclass(frozen=True, eq=False)
class Truth:
    theta: np.ndarray
    q: float
    laws: tuple
    wrong: np.ndarray
    constant_sd: np.ndarray
    states: np.ndarray
    weights: np.ndarray
    livelier: np.ndarray
    shares: np.ndarray


def scale_from_prior(rng, nominal, weak=WEAK):
    return float(nominal * np.sqrt(weak / rng.chisquare(weak)))


def law_from_prior(rng, about):
    if isinstance(about, StudentT):
        while True:
            nu = rng.gamma(2.0, 10.0)
            if 0.5 < nu < 100.0:
                return StudentT(nu, scale=scale_from_prior(rng, about.scale))
    core = scale_from_prior(rng, about.core_scale)
    wide = scale_from_prior(rng, about.core_scale * about.scale)
    rate = rng.beta(RATE_ROWS * about.rate, RATE_ROWS * (1.0 - about.rate))
    return Contaminated(max(rate, 1e-9), max(wide / core, 1.5), core_scale=core)


def draw_all(rng, about=ABOUT, targets=6, each=14, wrong_share=0.1):
    """A model, and what its reports were made from: three sensors of positions, two biased."""
    n = targets * each
    target, time = np.repeat(np.arange(targets), each), rng.uniform(0.0, 120.0, n)
    sensor = rng.integers(0, 3, n)
    sigmas, axes = np.array([40.0, 60.0]), PositionAxes(2)
    biased = [((0, Constant(0)), (1, Constant(1))), ((2, Constant(0)), (3, Constant(1)))]
    models = (
        SensorModel(axes, sigmas),
        SensorModel(axes, sigmas, biased[0], ((0, Constant(0)),)),
        SensorModel(axes, sigmas, biased[1]),
    )
    reports = TrackReports(models, sensor, target, time, np.zeros((n, 2)), 4, 2, 1)
    centre = np.zeros((n, 2))
    model = TrackModel(
        reports,
        GaussianPrior.from_sd(np.full(4, 100.0)),
        (about,) * 3,
        acceleration=4.0,
        acceleration_log_sd=1.0,
        wrong_share=wrong_share,
        area_m2=AREA_M2,
        start_sd=(20e3, 20e3, 100.0, 100.0),
        constant_sd=(60.0,),
        guess=PathPoints(time, centre, centre),
    )
    q = float(4.0 * np.exp(rng.standard_normal()))
    laws = tuple(law_from_prior(rng, about) for _ in range(3))
    prior = WRONG_ROWS * wrong_share
    wrong = rng.beta(prior, WRONG_ROWS - prior, 3) if wrong_share else np.zeros(3)
    spread = np.array([scale_from_prior(rng, 60.0, CONSTANT_TARGETS)])
    theta = 100.0 * rng.standard_normal(4)
    # the order of targets and times is that of the tangent
    shares = rng.dirichlet(level_targets(model))
    livelier = rng.choice(model.levels, targets, p=shares)
    blank = reports.linearise(np.zeros(4), model.guess)
    states, observed = draw_model(
        blank.equations, model.motion(blank.equations, q * livelier, spread), rng
    )
    seen = observed.reshape(n, 2)
    own = sensor[blank.rows]
    seen += np.stack([np.zeros(2), theta[:2], theta[2:]])[own]
    precision = np.empty(n)
    for s in range(3):
        mine = np.flatnonzero(own == s)
        precision[mine] = precision_from(laws[s], rng, len(mine))
    noise = rng.standard_normal((n, 2)) * sigmas / np.sqrt(precision)[:, None]
    elsewhere = rng.random(n) < wrong[own]
    side = np.sqrt(AREA_M2)
    values = np.where(elsewhere[:, None], side * (rng.random((n, 2)) - 0.5), seen + noise)
    back = np.empty_like(values)
    back[blank.rows] = values
    model = replace(model, reports=replace(reports, values=back))
    weights = np.where(elsewhere, 0.0, precision)
    return model, Truth(theta, q, laws, wrong, spread, states, weights, livelier, shares)


def precision_from(law, rng, n):
    if isinstance(law, StudentT):
        return rng.chisquare(law.nu, n) / law.nu / law.scale**2
    bad = rng.random(n) < law.rate
    return np.where(bad, law.scale**-2.0, 1.0) / law.core_scale**2


def point_at(model, truth):
    """The point of the truth: a draw from the posterior of its own data."""
    tangent = model.reports.linearise(np.zeros(4), model.guess)
    given = truth.weights, truth.q, truth.laws, truth.wrong, truth.constant_sd
    return Point(tangent, *given, truth.livelier, truth.shares)
