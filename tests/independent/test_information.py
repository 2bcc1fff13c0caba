"""What the geometry can tell of range biases and of the barometer's, by exact information."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.independent.cases import OFFSET_M, SHARE, easy, near
from tests.independent.earth import displaced
from tests.independent.information import covariance, information, names_of
from tests.independent.scene import Barometer

TERMS = {"height": OFFSET_M, "height_gain": SHARE}


def targets(scene, heights, n=600):
    rng = np.random.default_rng(0)
    away, course = scene.region_m * np.sqrt(rng.random(n)), rng.uniform(0.0, 2.0 * np.pi, n)
    move = np.stack([away * np.sin(course), away * np.cos(course), np.zeros(n)], axis=1)
    centre = np.array([*np.deg2rad(scene.centre_deg), 0.0])
    places = displaced(np.broadcast_to(centre, (n, 3)), move)
    places[:, 2] = rng.uniform(*heights, n)
    return places


def sd_of(scene, places):
    return dict(zip(names_of(scene), np.sqrt(np.diag(covariance(scene, places))), strict=True))


def ranges(sd):
    return np.array([value for name, value in sd.items() if name.endswith(".range")])


def test_one_radar_and_a_reference_in_closed_form():
    # due north and level with the radar its range is the reference's north
    scene = easy()
    radar = replace(scene.radars[0], unknown={"range": 60.0}, refraction=False)
    heights = Barometer(sigma_m=5.0, unknown={"height": OFFSET_M})
    scene = replace(scene, radars=(radar,), barometer=heights)
    places = displaced(radar.place[None], np.array([[0.0, 30e3, 0.0]]))
    found = information(scene, np.repeat(places, 7, axis=0))
    slant = 7.0 / (radar.sigma_range_m**2 + scene.positions.sigma_m**2)
    height = 7.0 / (5.0**2 + scene.positions.sigma_height_m**2)
    # their verticals are a quarter of a degree apart: a little of one in the other
    np.testing.assert_allclose(found, np.diag([slant, height]), rtol=1e-4, atol=2e-5)


@pytest.mark.parametrize("case", [easy, near])
def test_with_a_reference_barometric_terms_cost_nothing(case):
    scene, open_ones = case(), replace(case(), barometer=Barometer(unknown=TERMS))
    places = targets(scene, (9e3, 11e3))
    plain, free = sd_of(scene, places), sd_of(open_ones, places)
    np.testing.assert_allclose(ranges(free) / ranges(plain), 1.0, atol=0.01)
    # and a constant slant range and a constant height are told apart
    found = covariance(open_ones, places)
    scale = np.sqrt(np.diag(found))
    correlation = (found / scale[:, None] / scale)[:-2, -2:]
    assert np.abs(correlation).max() < 0.1


@pytest.mark.parametrize("case", [easy, near])
def test_without_one_they_cost_up_to_half_of_the_range_sd_and_stay_determined(case):
    scene = replace(case(), positions=None)
    open_ones = replace(scene, barometer=Barometer(unknown=TERMS))
    places = targets(scene, (9e3, 11e3))
    plain, free = sd_of(scene, places), sd_of(open_ones, places)
    ratio = ranges(free) / ranges(plain)
    assert ratio.min() > 1.1
    assert ratio.max() < 1.6
    assert ranges(free).max() < 0.08 * 60.0


def test_en_route_offset_and_share_are_one_number():
    scene = replace(easy(), positions=None, barometer=Barometer(unknown=TERMS))
    places = targets(scene, (9e3, 11e3))
    block = covariance(scene, places)[-2:, -2:]
    at_mean = np.array([1.0, places[:, 2].mean()])
    together = np.sqrt(at_mean @ block @ at_mean)
    assert together < 0.3 * np.sqrt(block[0, 0])
    assert together < 0.3 * OFFSET_M
