"""Simulated traffic as a track model, and the bound of an oracle that knows who is who."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from probreg.noise import Contaminated
from probreg.posterior.tracks import Point, TrackModel, solve
from probreg.prior import GaussianPrior
from probreg.problems.recording.sensor_model import SensorModel
from probreg.problems.recording.track_reports import PathPoints, TrackReports
from probreg.scenarios.traffic import TrafficScene, simulate
from probreg.sensors.axes import PolarAxes
from probreg.sensors.terms import known_terms

AREA_M2 = (300e3) ** 2


def draw(seed, **scene):
    return simulate(TrafficScene(**scene), np.random.default_rng(seed))


def model_of(recording, setup, law=None, **options):
    """A track model of radars with the terms that the setup asks for, and the terms' names."""
    models, names, sds = [], [], []
    for sensor in recording.sensors:
        own = known_terms(sensor)
        asked = setup.biases[sensor.name]
        which = ("range", "azimuth", "elevation")[: sensor.dim]
        axes = PolarAxes(np.array(sensor.position), which, from_north=sensor.from_north)
        terms = tuple((len(names) + j, own[term]) for j, term in enumerate(asked))
        names += [f"{sensor.name}.{term}" for term in asked]
        sds += [own[term].prior_sd for term in asked]
        models.append(SensorModel(axes, sensor.sigmas, terms))
    reports = TrackReports(
        tuple(models),
        recording.sensor,
        recording.target,
        recording.time,
        recording.values,
        len(names),
        recording.sensors[0].dim,
    )
    laws = (Contaminated(0.05, 10.0) if law is None else law,) * len(models)
    prior = GaussianPrior.from_sd(np.array(sds))
    return TrackModel(reports, prior, laws, area_m2=AREA_M2, **options), names


def oracle(model, truth, q, outlier_factor=10.0):
    """The posterior of one who knows identities, noise, and where the targets are.

    `q` is the density of all accelerations or, as a fit has it, of each target's.
    """
    known = replace(model.reports, target=truth.target)
    model = replace(model, reports=known, guess=None)
    at = PathPoints(truth.time, truth.positions[:, : known.dim], np.zeros((len(known), known.dim)))
    tangent = known.linearise(np.array(list(truth.bias.values())), at)
    weights = np.where(truth.outlier, outlier_factor**-2.0, 1.0)[tangent.rows]
    none, K = np.zeros(len(model.laws)), known.num_targets
    density = np.full(K, np.min(q))  # targets that no report names move as most do
    if np.ndim(q):
        density[: len(q)] = q[:K]
    return solve(model, Point(tangent, weights, 1.0, model.laws, none, np.zeros(0), density))


def oracle_sd(model, truth, q, outlier_factor=10.0):
    return np.sqrt(np.diag(oracle(model, truth, q, outlier_factor).covariance))


def not_as_said(recording, fit):
    """Probability that each report is not of the target it names, or is an outlier."""
    moved = fit.target != recording.target
    return np.where(moved, 1.0 - fit.wrong, fit.wrong + fit.outlier)
