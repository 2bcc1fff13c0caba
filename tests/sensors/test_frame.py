"""The rigid frame and sensors' own levels, against earth-centred geometry by pyproj alone."""

from __future__ import annotations

import numpy as np
import pytest
from pyproj import Geod, Transformer

from probreg.errors import InvalidInputError
from probreg.sensors.frame import LocalFrame, level_axes
from probreg.sensors.geometry import azimuth_from_north, wrap_angle
from probreg.sensors.placement import Placement

ORIGIN, SITE = (50.1, 8.1, 250.0), (51.4, 10.6, 620.0)
GEOCENTRIC = Transformer.from_crs(4979, 4978)


def geocentric(places):
    """Earth-centred coordinates by another road through pyproj than that of the package."""
    return np.stack(GEOCENTRIC.transform(*np.moveaxis(np.asarray(places), -1, 0)), axis=-1)


def aircraft(n=300, seed=1, centre=ORIGIN):
    rng = np.random.default_rng(seed)
    spread = rng.uniform((-2.5, -3.5, 0.0), (2.5, 3.5, 12e3), (n, 3))
    return spread + np.array([centre[0], centre[1], 500.0])


def seen_from(site, places):
    """Slant range, compass azimuth and elevation from a site, in its own topocentric pipeline."""
    latitude, longitude, height = site
    own = Transformer.from_pipeline(
        f"+proj=topocentric +ellps=WGS84 +lat_0={latitude} +lon_0={longitude} +h_0={height}"
    )
    east, north, up = own.transform(*geocentric(places).T)
    distance = np.sqrt(east**2 + north**2 + up**2)
    return distance, np.arctan2(east, north), np.arcsin(up / distance)


def test_the_frame_is_a_rotation_about_the_origin_and_keeps_every_distance():
    frame, places = LocalFrame(*ORIGIN), aircraft()
    x, X = frame.from_geodetic(places), geocentric(places)
    axes = level_axes(np.array(ORIGIN[0]), np.array(ORIGIN[1]))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(x, (X - geocentric(ORIGIN)) @ axes.T, atol=1e-6)
    far = np.linalg.norm(x[:, None] - x, axis=-1)
    np.testing.assert_allclose(far, np.linalg.norm(X[:, None] - X, axis=-1), atol=1e-6)
    np.testing.assert_allclose(frame.to_geodetic(x), places, atol=1e-7)


@pytest.mark.parametrize("site", [SITE, (49.0, 5.0, 40.0), (50.1, 8.1, 250.0)])
def test_a_placed_sensor_sees_what_its_own_topocentric_frame_says(site):
    frame, places = LocalFrame(*ORIGIN), aircraft(centre=site)
    polar = frame.placement(np.array(site)).polar(frame.from_geodetic(places))
    distance, compass, elevation = seen_from(site, places)
    np.testing.assert_allclose(polar[:, 0], distance, atol=1e-6)
    turn = wrap_angle(azimuth_from_north(polar[:, 1]) - compass)
    np.testing.assert_allclose(turn * distance * np.cos(elevation), 0.0, atol=1e-6)
    np.testing.assert_allclose((polar[:, 2] - elevation) * distance, 0.0, atol=1e-6)


@pytest.mark.parametrize("kilometres", [40.0, 80.0])
def test_the_vertical_of_a_sensor_away_from_the_origin_is_tilted(kilometres):
    # 0.36 degrees at 40 km and 0.72 at 80: what an elevation errs by where the tilt is left out
    frame = LocalFrame(*ORIGIN)
    for course in (0.0, 90.0, 215.0):
        longitude, latitude, _ = Geod(ellps="WGS84").fwd(
            ORIGIN[1], ORIGIN[0], course, 1e3 * kilometres
        )
        site = (latitude, longitude, 100.0)
        placed = frame.placement(np.array(site))
        tilt = np.rad2deg(np.arccos(placed.level[2, 2]))
        assert tilt == pytest.approx(kilometres / 111.2, rel=4e-3)
        places = aircraft(centre=site)
        distance, _, elevation = seen_from(site, places)
        low = (distance > 2e4) & (elevation < 0.3)
        flat = Placement(placed.position).polar(frame.from_geodetic(places))
        error = np.rad2deg(np.abs(flat[:, 2] - elevation)[low]).max()
        assert error == pytest.approx(tilt, rel=0.03)


def test_heights_and_their_derivatives():
    frame, places = LocalFrame(*ORIGIN), aircraft()
    x = frame.from_geodetic(places)
    height, up = frame.height(x)
    np.testing.assert_allclose(height, places[:, 2], atol=1e-6)
    step = 10.0
    for axis in range(3):
        ahead, back = (frame.to_geodetic(x + s * np.eye(3)[axis])[:, 2] for s in (step, -step))
        np.testing.assert_allclose(up[:, axis], (ahead - back) / (2.0 * step), atol=1e-8)


def test_many_places_at_once_are_those_one_by_one():
    frame = LocalFrame(*ORIGIN)
    sites, x = aircraft(20, seed=2), frame.from_geodetic(aircraft(20, seed=3))
    many = frame.placement(sites)
    for k, site in enumerate(sites):
        one = frame.placement(site)
        np.testing.assert_allclose(many.level[k], one.level, atol=1e-15)
        np.testing.assert_allclose(many.polar(x)[k], one.polar(x[k]), rtol=1e-13)


def test_a_place_that_is_not_on_the_earth_is_refused():
    with pytest.raises(InvalidInputError, match="no latitude"):
        LocalFrame(90.0, 8.0)
