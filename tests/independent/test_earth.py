"""Geometry of the simulator at known places, by other ways through pyproj."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest
from pyproj import Geod, Transformer

from tests.independent.earth import displaced, earth_centred, look, place_of

GEOD = Geod(ellps="WGS84")
RADIUS_M = 6_371_000.0


def radians(latitude, longitude, height=0.0):
    return np.array([np.deg2rad(latitude), np.deg2rad(longitude), height])


def test_the_simulator_shares_no_code_with_the_package():
    for path in Path(__file__).parent.glob("*.py"):
        if path.name.startswith("test_"):
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            roots = {name.split(".")[0] for name in names}
            own = all(name.startswith("tests.independent") for name in names if "tests" in name)
            assert own
            assert "probreg" not in roots


def test_earth_centred_coordinates_of_known_places():
    # equator and pole from the axes of the ellipsoid alone
    np.testing.assert_allclose(earth_centred(radians(0, 0, 5.0)), [6378142.0, 0.0, 0.0], atol=1e-6)
    pole = earth_centred(radians(90, 0, 0.0))
    np.testing.assert_allclose(pole, [0.0, 0.0, 6356752.314245], atol=1e-6)
    rng = np.random.default_rng(0)
    places = np.column_stack(
        [rng.uniform(-1.4, 1.4, 50), rng.uniform(-3.0, 3.0, 50), rng.uniform(0.0, 12e3, 50)]
    )
    by_code = Transformer.from_crs(4979, 4978).transform(*np.rad2deg(places[:, :2]).T, places[:, 2])
    np.testing.assert_allclose(earth_centred(places), np.stack(by_code, axis=1), atol=1e-6)
    np.testing.assert_allclose(place_of(earth_centred(places)), places, atol=1e-8)


@pytest.mark.parametrize("course", [0.0, 37.0, 90.0, 200.0, 305.0])
@pytest.mark.parametrize("kilometres", [5.0, 60.0, 120.0])
def test_azimuth_and_distance_of_places_on_the_ellipsoid(course, kilometres):
    distance = 1e3 * kilometres
    longitude, latitude, _ = GEOD.fwd(9.0, 50.0, course, distance)
    seen = look(radians(50.0, 9.0), radians(latitude, longitude)[None])[0]
    # the normal section and the geodesic part by less than a tenth of a second of arc
    turn = np.rad2deg(seen[1]) - course
    assert (turn + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=3e-5)
    # chord and dip of an arc; radii of curvature differ from the mean one by half a percent
    assert distance - seen[0] == pytest.approx(distance**3 / 24.0 / RADIUS_M**2, rel=0.02, abs=1e-6)
    assert seen[2] == pytest.approx(-0.5 * distance / RADIUS_M, rel=0.01)


def test_straight_above_and_on_the_same_meridian():
    site = radians(50.0, 9.0, 300.0)
    above = look(site, radians(50.0, 9.0, 9300.0)[None])[0]
    assert above[0] == pytest.approx(9e3, abs=1e-6)
    assert above[2] == pytest.approx(0.5 * np.pi, abs=1e-6)
    north, south = look(site, np.stack([radians(50.5, 9.0, 1e4), radians(49.5, 9.0, 1e4)]))
    assert north[1] == pytest.approx(0.0, abs=1e-12)
    assert abs(south[1]) == pytest.approx(np.pi, abs=1e-12)


def test_displacements_are_along_the_local_axes():
    places = np.stack([radians(50.0, 9.0, 8e3), radians(-20.0, 170.0, 1e3)])
    moved = displaced(places, np.array([[0.0, 0.0, 70.0], [0.0, 25.0, 0.0]]))
    np.testing.assert_allclose(moved[0], [*places[0, :2], 8070.0], atol=1e-6)
    course, _, distance = GEOD.inv(170.0, -20.0, *np.rad2deg(moved[1, 1::-1]))
    # at a height of 1 km 25 m are 3.9 mm less on the ellipsoid
    assert distance == pytest.approx(25.0 * (1.0 - 1e3 / 6.34e6), abs=1e-4)
    assert course == pytest.approx(0.0, abs=1e-6)
