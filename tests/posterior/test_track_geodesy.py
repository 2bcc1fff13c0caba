"""Tracks over the ellipsoid, simulated by pyproj alone: no geometry is shared with the package."""

from __future__ import annotations

import numpy as np
import pyproj
import pytest
from scipy import stats

from probreg.noise import Contaminated
from probreg.posterior.tracks import TrackModel, fit_tracks
from probreg.prior import GaussianPrior
from probreg.problems.recording.sensor_model import SensorModel
from probreg.problems.recording.track_reports import TrackReports
from probreg.sensors.axes import EARTH_RADIUS_M, HeightAxes, PolarAxes
from tests.problems.test_track_reports import Constant, level, to_earth

ORIGIN = (47.0, 8.0, 400.0)
PLACES = ((47.1, 8.2, 500.0), (46.2, 6.1, 450.0), (48.4, 9.9, 900.0), (47.9, 7.0, 300.0))
SIGMAS = np.array([40.0, 1.2e-3, 1.5e-3])  # range, azimuth, elevation
GEOD = pyproj.Geod(ellps="WGS84")


def flights(rng, count, time, target):
    """Latitudes, longitudes, heights of level and climbing aircraft on geodesics."""
    course, speed = rng.uniform(0.0, 360.0, count), rng.uniform(150.0, 250.0, count)
    latitude, longitude = rng.uniform(46.2, 48.2, count), rng.uniform(6.5, 9.5, count)
    climb = np.where(rng.random(count) < 0.4, rng.uniform(-8.0, 8.0, count), 0.0)
    high = rng.uniform(4e3, 9e3, count)
    away = speed[target] * time
    lon, lat, _ = GEOD.fwd(longitude[target], latitude[target], course[target], away)
    return np.asarray(lat), np.asarray(lon), high[target] + climb[target] * time


def seen_from(place, earth):
    """Slant range, azimuth from north and elevation by the sensor's own level."""
    local = (earth - to_earth(*place)) @ level(*place[:2]).T
    distance = np.linalg.norm(local, axis=1)
    return np.stack(
        [distance, np.arctan2(local[:, 0], local[:, 1]), np.arcsin(local[:, 2] / distance)], axis=1
    )


def simulate(seed, n=4000, count=30, heights=True):
    """Three radars without and one with elevation, 60 to 250 km apart, and heights."""
    rng = np.random.default_rng(seed)
    target, time = rng.integers(0, count, n), rng.uniform(0.0, 500.0, n)
    lat, lon, high = flights(rng, count, time, target)
    earth = to_earth(lat, lon, high)
    true = rng.standard_normal(9) * np.array([*[60.0, 3e-3] * 4, 3e-3])
    sensor = rng.integers(0, 4, n)
    here, models = level(*ORIGIN[:2]), []
    values = np.full((n, 3), np.nan)
    for k, place in enumerate(PLACES):
        own, q = sensor == k, 3 if k == 3 else 2
        bias = true[[2 * k, 2 * k + 1, 8]][:q]
        report = seen_from(place, earth[own])[:, :q] + bias
        values[own, :q] = report + rng.standard_normal(report.shape) * SIGMAS[:q]
        position = here @ (to_earth(*place) - to_earth(*ORIGIN))
        turned = level(*place[:2]) @ here.T
        axes = PolarAxes(position, ("range", "azimuth", "elevation")[:q], turned, from_north=True)
        terms = [(2 * k, Constant(0)), (2 * k + 1, Constant(1)), (8, Constant(2))][:q]
        models.append(SensorModel(axes, SIGMAS[:q], tuple(terms)))
    if heights:
        axes = HeightAxes(np.deg2rad(ORIGIN[0]), ORIGIN[2])
        models.append(SensorModel(axes, np.array([10.0])))
        own = np.column_stack([high + 10.0 * rng.standard_normal(n), np.full((n, 2), np.nan)])
        sensor, values = np.concatenate([sensor, np.full(n, 4)]), np.vstack([values, own])
        target, time = np.tile(target, 2), np.tile(time, 2)
    reports = TrackReports(tuple(models), sensor, target, time, values, 9, 3, 0, EARTH_RADIUS_M)
    return reports, true


def errors(seed, **options):
    reports, true = simulate(seed, **options)
    sd = np.array([*[200.0, 1e-2] * 4, 1e-2])
    laws = (Contaminated(0.02, 10.0),) * len(reports.models)
    model = TrackModel(reports, GaussianPrior.from_sd(sd), laws, acceleration=0.01)
    fit = fit_tracks(model)
    return (fit.theta - true) / fit.sd


@pytest.mark.parametrize("heights", [True, False])
def test_biases_are_right_at_any_distance(heights):
    z = np.concatenate([errors(seed, heights=heights) for seed in range(3)])
    # a false alarm in a thousand
    low, high = stats.chi2(z.size).ppf([5e-4, 1.0 - 5e-4])
    assert low < (z**2).sum() < high
    assert np.abs(z).max() < stats.norm.isf(0.5e-3 / z.size)
