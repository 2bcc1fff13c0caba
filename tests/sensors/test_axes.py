"""Sensors' own axes: against pyproj, finite differences, and each other."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.sensors import (
    Barometer,
    BearingSensor,
    Height,
    PositionSensor,
    Radar2D,
    Radar3D,
    Site,
)
from probreg.sensors.axes import GeodeticAxes, HeightAxes, PolarAxes, PositionAxes
from probreg.sensors.frame import LocalFrame
from probreg.sensors.geometry import wrap_angle
from probreg.sensors.refraction import refraction

ORIGIN, PLACE = (50.1, 8.1, 250.0), (51.4, 10.6, 620.0)
FRAME = LocalFrame(*ORIGIN)
EARTH = Site(3, FRAME)
RADAR = Radar3D(tuple(FRAME.from_geodetic(np.array(PLACE)).tolist()), 50.0, 1e-3, 2e-3, "r", True)
FLAT = Radar2D(RADAR.position, 50.0, 1e-3, "f", from_north=True)
POSITION = PositionSensor.independent((10.0, 10.0, 20.0))


def aircraft(n=200, seed=1, low=500.0):
    rng = np.random.default_rng(seed)
    return rng.uniform((48.5, 6.0, low), (52.5, 12.0, 12e3), (n, 3))


KINDS = {
    "radar3d, own level": RADAR.axes(Site(3, FRAME, PLACE)),
    "radar2d, own level": FLAT.axes(Site(3, FRAME, PLACE)),
    "radar3d, of the frame": RADAR.axes(EARTH),
    "radar3d, flat": RADAR.axes(Site(3)),
    "radar2d, plane": FLAT.axes(Site(2)),
    "radar2d, plane, true north": FLAT.axes(Site(2, FRAME, PLACE)),
    "bearing": BearingSensor(0.01).axes(EARTH),
    "position": POSITION.axes(EARTH),
    "position without height": PositionSensor.independent((9.0, 9.0)).axes(EARTH),
    "geodetic": POSITION.axes(Site(3, FRAME, geodetic=True)),
    "geodetic without height": PositionSensor.independent((9.0, 9.0)).axes(
        Site(3, FRAME, geodetic=True)
    ),
    "geodetic, plane": PositionSensor.independent((9.0, 9.0)).axes(Site(2, FRAME, geodetic=True)),
    "height": Height(10.0).axes(EARTH),
    "height, flat": Barometer(10.0).axes(Site(3)),
}


def dim_of(axes):
    return getattr(axes, "dim", len(getattr(axes, "position", np.zeros(3))))


@pytest.mark.parametrize("kind", KINDS)
def test_gradients_are_finite_differences(kind):
    axes = KINDS[kind]
    x = FRAME.from_geodetic(aircraft())[:, : dim_of(axes)]
    seen = axes.observe(x)
    for a in range(x.shape[1]):
        step = np.eye(x.shape[1])[a]
        slope = axes.observe(x + step).value - axes.observe(x - step).value
        slope[:, axes.angles] = wrap_angle(slope[:, axes.angles])
        np.testing.assert_allclose(seen.gradient[..., a], 0.5 * seen.factor * slope, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_reports_are_placed_where_they_were_made(kind):
    axes = KINDS[kind]
    places = aircraft()
    if dim_of(axes) == 2:
        places[:, 2] = 0.0
    x = FRAME.from_geodetic(places)[:, : dim_of(axes)]
    height = x[:, 2] if kind in ("radar3d, flat", "position without height") else places[:, 2]
    there = axes.place(axes.observe(x).value, height)
    if kind in ("bearing", "height", "height, flat"):
        assert np.isnan(there).all()
        return
    # a two-dimensional radar on a sphere instead of the ellipsoid: a guess
    loose = 30.0 if kind == "radar2d, own level" else 1e-5
    np.testing.assert_allclose(there, x, atol=loose)


def test_the_compact_ellipsoid_is_that_of_pyproj():
    places = aircraft(low=-200.0)
    x = FRAME.from_geodetic(places)
    axes = KINDS["geodetic"]
    values = axes.observe(x).value
    np.testing.assert_allclose(axes.values(places), values, atol=1e-6)
    found = axes.places(values)
    np.testing.assert_allclose(found[:, :2], places[:, :2], atol=1e-11)
    np.testing.assert_allclose(found[:, 2], places[:, 2], atol=1e-6)
    np.testing.assert_allclose(axes.place(values, np.zeros(200)), x, atol=1e-6)
    high = HeightAxes(np.deg2rad(50.1), 250.0).observe(x).value[:, 0]
    np.testing.assert_allclose(high, places[:, 2], atol=1e-6)
    # rows for a metre of the target: up is up, north is north, east leans as the meridians do
    seen = axes.observe(x)
    _, up = FRAME.height(x)
    np.testing.assert_allclose(seen.gradient[:, 2], up, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(seen.gradient[:, 1], axis=1), 1.0, atol=1e-12)
    turn = np.sin(np.deg2rad(places[:, 0])) * np.deg2rad(places[:, 1] - ORIGIN[1])
    leaning = np.einsum("nd,nd->n", seen.gradient[:, 0], seen.gradient[:, 1])
    np.testing.assert_allclose(-leaning, turn, atol=3e-4)
    np.testing.assert_allclose(seen.factor, 1.0, atol=4e-3)
    # across the date line
    far = GeodeticAxes((10.0, 179.9, 0.0))
    there = np.array([[10.0, -179.9, 5e3]])
    assert far.values(there)[0, 0] == pytest.approx(21.9e3, rel=0.01)
    turn = np.deg2rad(far.places(far.values(there)) - there)[:, :2]
    np.testing.assert_allclose(wrap_angle(turn), 0.0, atol=1e-9)


def test_latitude_and_longitude_say_where_a_target_is_at_any_height():
    places = aircraft()
    low, high = (places * [1.0, 1.0, 0.0] + [0.0, 0.0, up] for up in (0.0, 12e3))
    axes = KINDS["geodetic without height"]
    one, two = (axes.observe(FRAME.from_geodetic(p)).value for p in (low, high))
    np.testing.assert_allclose(one, two, atol=1e-5)
    # in the coordinates of the frame the same two are hundreds of metres apart
    flat = KINDS["position without height"]
    one, two = (flat.observe(FRAME.from_geodetic(p)).value for p in (low, high))
    assert np.linalg.norm(one - two, axis=1).max() > 100.0
    up = FRAME.height(FRAME.from_geodetic(places))[1]
    rows = axes.observe(FRAME.from_geodetic(places)).gradient
    np.testing.assert_allclose(np.einsum("nqd,nd->nq", rows, up), 0.0, atol=1e-9)


def test_a_radar_sees_about_its_own_level():
    places = aircraft()
    local = LocalFrame(*PLACE).from_geodetic(places)
    distance = np.linalg.norm(local, axis=1)
    wanted = [distance, np.arctan2(local[:, 0], local[:, 1]), np.arcsin(local[:, 2] / distance)]
    x = FRAME.from_geodetic(places)
    seen = KINDS["radar3d, own level"].observe(x).value
    np.testing.assert_allclose(seen, np.stack(wanted, axis=1), atol=1e-6)
    np.testing.assert_array_equal(KINDS["radar2d, own level"].observe(x).value, seen[:, :2])
    # the control: its level is a degree and a half from that of the frame
    frame = KINDS["radar3d, of the frame"].observe(x).value
    assert np.abs(frame[:, 2] - seen[:, 2]).max() > 0.02


@pytest.mark.parametrize("sensor", [RADAR, FLAT])
def test_refraction_is_added_to_values_and_gradients(sensor):
    bent = sensor.axes(Site(3, FRAME, PLACE, refraction=True))
    straight = sensor.axes(Site(3, FRAME, PLACE))
    x = FRAME.from_geodetic(aircraft(1_000))
    true = RADAR.axes(Site(3, FRAME, PLACE)).observe(x).value
    seen_from_above = true[:, 2] > np.deg2rad(0.5)
    x, true = x[seen_from_above], true[seen_from_above]
    added = refraction(true[:, 0], true[:, 2], PLACE[2])
    seen, plain = bent.observe(x), straight.observe(x)
    wanted = np.stack([added.range, 0.0 * added.range, added.elevation], axis=1)
    q = seen.value.shape[1]
    np.testing.assert_allclose(seen.value - plain.value, wanted[:, :q], atol=1e-9)
    slopes = []
    for step in 10.0 * np.eye(3):
        slope = bent.observe(x + step).value - bent.observe(x - step).value
        slope[:, 1] = wrap_angle(slope[:, 1])
        slopes.append(seen.factor * slope / 20.0)
    left = np.linalg.norm(np.stack(slopes, axis=2) - seen.gradient, axis=2)
    assert left[:, 0].max() < 4e-3
    assert left[:, 1].max() < 1e-5
    if q == 3:
        assert left[:, 2].max() < 4e-3
        # the control: of the straight line it is off by more than a twentieth
        rest = np.linalg.norm(np.stack(slopes, axis=2) - plain.gradient, axis=2)
        assert rest[:, 2].max() > 0.05
    there = bent.place(seen.value, FRAME.height(x)[0])
    np.testing.assert_allclose(there, x, atol=30.0 if q == 2 else 6.0)


def test_on_the_vertical_an_azimuth_says_nothing():
    flat = Radar3D((1e3, 2e3, 30.0), 50.0, 1e-3, 1e-3).axes(Site(3))
    above = np.array([[1e3, 2e3, 9e3], [2e3, 2e3, 9e3], [1e3, 2e3, 30.0]])
    seen = flat.observe(above)
    assert np.isfinite(seen.value).all()
    np.testing.assert_array_equal(seen.gradient[0], [[0, 0, 1], [0, 0, 0], [0, 0, 0]])
    np.testing.assert_array_equal(seen.factor[0], [1.0, 0.0, 0.0])
    assert not seen.gradient[2].any()
    assert seen.factor[1, 1] == 1e3


def test_a_height_that_is_not_given_is_zero_above_the_earth():
    away = Radar2D((90e3, 40e3), 50.0, 1e-3, from_north=True)
    axes = away.axes(EARTH)
    assert axes.height == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_array_equal(axes.position[:2], [90e3, 40e3])
    assert axes.position[2] < -900.0
    np.testing.assert_array_equal(away.axes(Site(3)).position, [90e3, 40e3, 0.0])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PolarAxes(np.zeros(3), refracted=True), "refraction needs"),
        (lambda: PolarAxes(np.zeros(2), ("range", "azimuth"), refracted=True), "refraction needs"),
        (lambda: PositionAxes(2, 3), "3 coordinates reported in 2 dimensions"),
        (lambda: GeodeticAxes(ORIGIN, 2, 3), "3 coordinates reported in 2 dimensions"),
        (lambda: POSITION.axes(Site(3, geodetic=True)), "needs an origin"),
        (lambda: Height(0.0), "sigma_height of sensor 'height'"),
        (lambda: POSITION.check(np.array([[1.0, np.nan, 2.0]])), "'position'"),
        (lambda: POSITION.check(np.array([[1.0, 2.0, np.inf]])), "'position'"),
        (lambda: Barometer(1.0).check(np.array([[np.nan]])), "'barometer'"),
    ],
)
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(InvalidInputError, match=message):
        make()


def test_the_height_of_a_position_may_be_missing():
    given = np.array([[1.0, 2.0, np.nan], [1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(POSITION.check(given), given)
