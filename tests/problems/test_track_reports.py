"""Reports as equations: against finite differences, pyproj and the contrasts of one instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyproj
import pytest

from probreg import Radar2D, ReportProblem
from probreg.errors import InvalidInputError
from probreg.motion.tracks import eliminate_paths, smooth_tracks, track_motion
from probreg.problems.recording.first_guess import first_guess
from probreg.problems.recording.sensor_model import SensorModel
from probreg.problems.recording.track_reports import PathPoints, TrackReports
from probreg.sensors import terms
from probreg.sensors.axes import HeightAxes, PolarAxes, PositionAxes, Site, fall
from probreg.sensors.terms import known_terms
from tests.conftest import PAIR_BIAS, polar_reports, radar_pair


def turn(seed):
    """A random rotation."""
    root, upper = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    root = root * np.sign(np.diag(upper))
    return root if np.linalg.det(root) > 0.0 else root[:, [1, 0, 2]]


SPACE = np.array([3e3, -2e3, 50.0])
KINDS = {
    "radar2d": PolarAxes(SPACE[:2], ("range", "azimuth"), from_north=True),
    "radar2d, slant": PolarAxes(SPACE, ("range", "azimuth"), turn(1)),
    "radar3d": PolarAxes(SPACE, rotation=turn(2), from_north=True),
    "bearing": PolarAxes(SPACE[:2], ("azimuth",)),
    "position": PositionAxes(3),
    "flat height": HeightAxes(),
    "height": HeightAxes(np.deg2rad(47.0), 400.0),
}


@pytest.mark.parametrize("kind", KINDS)
def test_directions_are_finite_differences_of_reports(kind):
    axes = KINDS[kind]
    d = len(axes.position) if isinstance(axes, PolarAxes) else 3
    x = np.random.default_rng(3).uniform(5e3, 40e3, (6, d))
    seen = axes.observe(x)
    for a in range(d):
        step = 0.5 * np.eye(d)[a]
        slope = axes.observe(x + step).value - axes.observe(x - step).value
        np.testing.assert_allclose(seen.gradient[:, :, a], seen.factor * slope, atol=1e-6)


@pytest.mark.parametrize("kind", ["radar3d", "radar2d", "position"])
def test_a_report_is_placed_where_the_target_is(kind):
    axes = KINDS[kind]
    d = len(axes.position) if isinstance(axes, PolarAxes) else 3
    x = np.random.default_rng(4).uniform(5e3, 40e3, (6, d))
    np.testing.assert_allclose(axes.place(axes.observe(x).value, np.zeros(6)), x, atol=1e-6)


def to_earth(latitude, longitude, height):
    transform = pyproj.Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    return np.stack(transform.transform(longitude, latitude, height), axis=-1)


def level(latitude, longitude):
    lat, lon = np.deg2rad([latitude, longitude])
    return np.array(
        [
            [-np.sin(lon), np.cos(lon), 0.0],
            [-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)],
            [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)],
        ]
    )


def test_heights_are_those_of_the_ellipsoid():
    origin = (47.3, 8.2, 430.0)
    rng = np.random.default_rng(5)
    latitude, longitude = rng.uniform(44.0, 50.0, 20), rng.uniform(4.0, 12.0, 20)
    height = rng.uniform(0.0, 12e3, 20)
    earth = to_earth(latitude, longitude, height)
    x = (earth - to_earth(*origin)) @ level(*origin[:2]).T
    seen = HeightAxes(np.deg2rad(origin[0]), origin[2]).observe(x)
    np.testing.assert_allclose(seen.value[:, 0], height, atol=1e-3)
    up = np.array(
        [level(*origin[:2]) @ level(*at)[2] for at in zip(latitude, longitude, strict=True)]
    )
    np.testing.assert_allclose(seen.gradient[:, 0], up, atol=1e-9)


def test_level_flight_falls_along_a_great_circle():
    radius, speed = 6.37e6, 230.0
    angle = speed / (radius + 1e4) * np.arange(0.0, 600.0, 1.0)
    path = (radius + 1e4) * np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    path[:, 2] -= radius
    velocity = np.gradient(path, axis=0)
    wanted = np.gradient(velocity, axis=0)[5:-5]
    found = fall(path, velocity, radius)[5:-5]
    np.testing.assert_allclose(found, wanted, atol=2e-5)


def models_of(sensors):
    """Array-level twins of package radars; constant biases in the order of a ReportProblem."""
    found, start = [], 0
    for sensor in sensors:
        which = ("range", "azimuth", "elevation")[: len(sensor.bias_names)]
        axes = PolarAxes(np.array(sensor.position), which, from_north=sensor.from_north)
        own = terms.known_terms(sensor)
        places = tuple((start + j, own[name]) for j, name in enumerate(sensor.bias_names))
        found.append(SensorModel(axes, sensor.sigmas, places))
        start += len(places)
    return tuple(found)


def at_one_instant(data):
    """Every row a target, its reports at the row's time."""
    n, k = len(data), len(data.sensors)
    values = np.stack(data.values, axis=1)
    return TrackReports(
        models_of(data.sensors),
        np.tile(np.arange(k), n),
        np.repeat(np.arange(n), k),
        np.repeat(np.asarray(data.time), k),
        values.reshape(n * k, -1),
        sum(len(s.bias_names) for s in data.sensors),
        data.sensors[0].dim,
    )


def iterate(reports, passes=4):
    """Gauss-Newton from zero: biases, and the information at the last point."""
    theta, path = np.zeros(reports.num_biases), first_guess(reports)
    for _ in range(passes):
        tangent = reports.linearise(theta, path)
        first = tangent.rows[tangent.equations.target_start[:-1]]
        d = reports.dim
        start = np.hstack([path.position[first], np.zeros((len(first), d))])
        motion = track_motion(tangent.equations, 1.0, start, np.repeat([1e5, 350.0], d))
        found = eliminate_paths(tangent.equations, motion, reports.num_biases)
        # a clock says nothing of targets that stand still, as they do at first
        delta = np.linalg.solve(found.precision + 1e-9 * np.eye(len(theta)), found.shift)
        theta = tangent.theta + delta
        path = tangent.path(smooth_tracks(tangent.equations, motion, delta=delta).mean)
    return theta, found


def test_reports_of_one_instant_say_what_the_contrasts_say():
    data = polar_reports(radar_pair(), PAIR_BIAS, seed=5)
    theta, found = iterate(at_one_instant(data))
    problem = ReportProblem(data)
    wanted = np.zeros(6)
    for _ in range(4):
        linear = problem.linearise(wanted)
        inverse = np.linalg.inv(linear.R)
        J = np.einsum("nmp,nmk,nkq->pq", linear.B, inverse, linear.B)
        wanted = np.linalg.solve(J, np.einsum("nmp,nmk,nk->p", linear.B, inverse, linear.y))
    sd = np.sqrt(np.diag(np.linalg.inv(J)))
    # fused positions and smoothed ones are the same but for the curvature of the axes
    np.testing.assert_allclose(
        found.precision / np.outer(1 / sd, 1 / sd), J * np.outer(sd, sd), rtol=1e-4, atol=1e-4
    )
    assert np.abs((theta - wanted) / sd).max() < 0.05
    assert np.abs((theta - PAIR_BIAS) / sd).max() < 4.0


@dataclass(frozen=True)
class Late:
    """A clock that is ahead, free of any sensor class."""

    stamp: float = 1.0
    varies: bool = True

    def column(self, reports):
        return np.zeros_like(reports)


@dataclass(frozen=True)
class Constant:
    """An offset of one component."""

    component: int
    stamp: float = 0.0
    varies: bool = False

    def column(self, reports):
        out = np.zeros_like(reports)
        out[:, self.component] = 1.0
        return out


def moving_scene(theta=(0.0, 0.0), seed=6):
    """Two planar radars without noise, the second with a clock and a range bias; straight paths."""
    rng = np.random.default_rng(seed)
    axes = [PolarAxes(np.array(p), ("range", "azimuth")) for p in ([0.0, 0.0], [30e3, 5e3])]
    sigmas = np.array([30.0, 1e-3])
    models = (
        SensorModel(axes[0], sigmas),
        SensorModel(axes[1], sigmas, ((0, Constant(0)), (1, Late()))),
    )
    K, each = 6, 30
    start = rng.uniform(-40e3, 40e3, (K, 2))
    speed = rng.normal(0.0, 150.0, (K, 2))
    target, sensor = np.repeat(np.arange(K), each), rng.integers(0, 2, K * each)
    true_time = rng.uniform(0.0, 200.0, K * each)
    x = start[target] + true_time[:, None] * speed[target]
    values = np.stack([a.observe(x).value for a in axes])[sensor, np.arange(len(x))]
    values[:, 0] += theta[0] * sensor
    reports = TrackReports(models, sensor, target, true_time + theta[1] * sensor, values, 2)
    return reports, PathPoints(true_time, x, speed[target])


def left_over(tangent, position):
    """What no bias explains of each equation at positions (n, d)."""
    at = position[tangent.rows][tangent.equations.report]
    return tangent.equations.y - np.einsum("ed,ed->e", tangent.equations.h, at)


def test_columns_are_finite_differences_of_what_the_biases_do():
    true = np.array([50.0, 0.8])
    reports, path = moving_scene(true)
    # without noise every equation holds at the truth
    np.testing.assert_allclose(
        left_over(reports.linearise(true, path), path.position), 0.0, atol=1e-6
    )
    for c, step in enumerate((1.0, 1e-3)):
        # reports of another bias read with the old one, where the targets are at the times read
        moved, _ = moving_scene(true + step * np.eye(2)[c])
        tangent = moved.linearise(true, path)
        there = path.position + (moved.shifted_time(true) - path.time)[:, None] * path.velocity
        slope = np.where(tangent.equations.column == c, tangent.equations.response, 0.0).sum(axis=1)
        np.testing.assert_allclose(left_over(tangent, there) / step, slope, rtol=1e-3, atol=2e-2)
        assert np.abs(slope).max() > 0.9


def test_clock_and_range_are_found_from_zero_without_noise():
    true = np.array([50.0, 0.8])
    theta, _ = iterate(moving_scene(true)[0], passes=6)
    np.testing.assert_allclose(theta, true, rtol=2e-4)


def test_a_missing_component_is_no_equation_and_a_constant_of_the_target_is_found():
    reports, path = moving_scene()
    values = reports.values.copy()
    values[::7, 1] = np.nan
    own = (0, Constant(0))
    models = tuple(SensorModel(m.axes, m.sigmas, (), (own,)) for m in reports.models)
    delay = np.linspace(-80.0, 80.0, 6)
    values[:, 0] += delay[reports.target]
    late = TrackReports(models, reports.sensor, reports.target, reports.time, values, 0, 2, 1)
    tangent = late.linearise(np.zeros(0), path)
    assert len(tangent.equations.y) == np.isfinite(values).sum()
    first = tangent.rows[tangent.equations.target_start[:-1]]
    start = np.hstack([path.position[first], path.velocity[first], np.zeros((6, 1))])
    motion = track_motion(tangent.equations, 1e-4, start, np.repeat([1e4, 300.0, 1e4], [2, 2, 1]))
    states = smooth_tracks(tangent.equations, motion).mean
    np.testing.assert_allclose(states[tangent.equations.target_start[:-1], 4], delay, atol=0.5)


def test_heights_and_neighbours_serve_the_first_guess():
    axes = PolarAxes(np.zeros(3), ("range", "azimuth"))
    models = (
        SensorModel(axes, np.array([30.0, 1e-3])),
        SensorModel(HeightAxes(), np.array([30.0])),
    )
    x = np.array([[30e3, 4e3, 9e3], [31e3, 4e3, 9e3], [31e3, 4e3, 9e3]])
    values = np.vstack([axes.observe(x[:2]).value, [[9e3, np.nan]]])
    reports = TrackReports(
        models, np.array([0, 0, 1]), np.zeros(3, dtype=int), np.array([0.0, 5.0, 6.0]), values, 0, 3
    )
    guess = first_guess(reports).position
    np.testing.assert_allclose(guess, x, atol=90.0)  # the earth's curvature is in the guess
    only = TrackReports(models[1:], np.array([0]), np.array([0]), np.zeros(1), [[9e3]], 0, 3)
    with pytest.raises(InvalidInputError, match="no report places target 0"):
        first_guess(only)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sensor": np.array([0, 5])}, "beyond the 1"),
        ({"target": np.array([0, -1])}, "whole numbers"),
        ({"values": np.full((2, 2), np.nan)}, "report 0 .* no component"),
        ({"values": np.ones((2, 3))}, "shape"),
        ({"num_biases": 0}, "beyond the biases"),
    ],
)
def test_reports_that_cannot_be_are_refused(change, message):
    model = SensorModel(KINDS["radar2d"], np.array([30.0, 1e-3]), ((0, Constant(0)),))
    whole = {
        "models": (model,),
        "sensor": np.zeros(2, dtype=int),
        "target": np.zeros(2, dtype=int),
        "time": np.arange(2.0),
        "values": np.ones((2, 2)),
        "num_biases": 1,
    }
    with pytest.raises(InvalidInputError, match=message):
        TrackReports(**{**whole, **change})


def test_sensors_that_cannot_be_are_refused():
    with pytest.raises(InvalidInputError, match="rotation"):
        PolarAxes(np.zeros(3), rotation=2.0 * np.eye(3))
    with pytest.raises(InvalidInputError, match="components"):
        PolarAxes(np.zeros(2), ("range", "elevation"))
    with pytest.raises(InvalidInputError, match="above zero"):
        SensorModel(KINDS["bearing"], np.zeros(1))


def test_an_azimuth_on_the_vertical_of_its_sensor_says_nothing():
    model = SensorModel(PolarAxes(np.zeros(3), ("range", "azimuth")), np.array([30.0, 1e-3]))
    reports = TrackReports(
        (model,), np.array([0]), np.array([0]), np.zeros(1), np.array([[4000.0, 1.0]]), 0, 3
    )
    above = np.array([[0.0, 0.0, 4000.0]])
    equations = reports.linearise(np.zeros(0), PathPoints(np.zeros(1), above, np.zeros((1, 3))))
    equations = equations.equations
    assert (equations.variance > 0.0).all()
    assert (equations.h[1] == 0.0).all()
    assert equations.y[1] == 0.0


def test_columns_are_those_of_a_steady_path_and_all_else_of_the_path():
    gain = Radar2D((0.0, 0.0), 30.0, 1e-3, "a")
    terms = known_terms(gain)
    model = SensorModel(gain.axes(Site(2)), gain.sigmas, ((0, terms["range_gain"]), (1, Late())))
    there, steady = np.array([[3e4, 4e4]]), np.array([[6e4, 8e4]])
    fast = np.array([[100.0, 0.0]])
    reports = TrackReports(
        (model,), np.array([0]), np.array([0]), np.zeros(1), np.array([[5e4, 0.9]]), 2
    )
    path = PathPoints(np.zeros(1), there, np.zeros((1, 2)))
    plain = reports.linearise(np.zeros(2), path).equations
    found = reports.linearise(np.zeros(2), path, PathPoints(np.zeros(1), steady, fast)).equations
    for name in ("y", "h", "variance"):
        np.testing.assert_array_equal(getattr(found, name), getattr(plain, name))
    # the range of a place twice as far; minus the velocity along and across the line of sight
    np.testing.assert_allclose(plain.response, [[5e4, 0.0], [0.0, 0.0]], atol=1e-9)
    np.testing.assert_allclose(found.response, [[1e5, -60.0], [0.0, 80.0]], rtol=1e-12, atol=1e-9)
