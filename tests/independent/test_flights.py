"""Flights on the ellipsoid: geodesics, turns and climbs, and nothing that jumps."""

from __future__ import annotations

import numpy as np
import pytest
from pyproj import Geod

from tests.independent.cases import easy
from tests.independent.earth import earth_centred
from tests.independent.flights import BOTH, LEVEL, controls, fly
from tests.independent.looks import draw_flights

GEOD = Geod(ellps="WGS84")


def one(seconds, height=0.0, speed=230.0, track=1.0, turn=0.0, climb=0.0):
    start = np.array([[np.deg2rad(50.0)], [np.deg2rad(9.0)], [height], [track]])
    shape = (seconds + 1, 1)
    return fly(start, np.array([speed]), np.full(shape, turn), np.full(shape, climb))


@pytest.mark.parametrize("track", [0.0, 1.0, 2.6, 4.0])
def test_straight_level_flight_is_a_geodesic(track):
    flown = one(900, track=track)
    for second in (1, 300, 900):
        longitude, latitude, _ = GEOD.fwd(9.0, 50.0, np.rad2deg(track), 230.0 * second)
        found = np.rad2deg(flown.places[second, 0, :2])
        _, _, apart = GEOD.inv(longitude, latitude, found[1], found[0])
        assert apart < 1e-3


def test_a_standard_turn_closes_in_two_minutes():
    flown = one(120, speed=150.0, turn=np.deg2rad(3.0))
    x = earth_centred(flown.places[:, 0])
    assert np.linalg.norm(x[120] - x[0]) < 0.1
    assert np.linalg.norm(x[60] - x[0]) == pytest.approx(2.0 * 150.0 / np.deg2rad(3.0), rel=1e-4)
    # clockwise: from north to east first
    right = one(30, track=0.0, turn=np.deg2rad(3.0))
    assert right.places[-1, 0, 1] > right.places[0, 0, 1]


def test_between_the_seconds_speed_is_what_was_flown():
    flown = one(120, height=8e3, turn=np.deg2rad(1.5), climb=12.0)
    time = np.linspace(1.0, 119.0, 1731)
    step = 0.01
    ahead, back = (
        earth_centred(flown.at(np.zeros(len(time), dtype=int), time + s)) for s in (step, -step)
    )
    speed = np.linalg.norm(ahead - back, axis=1) / (2.0 * step)
    np.testing.assert_allclose(speed, np.hypot(230.0, 12.0), atol=2e-3)
    assert flown.places[-1, 0, 2] == pytest.approx(8e3 + 120 * 12.0)


def test_traffic_is_as_aircraft_are():
    scene = easy()
    flights = draw_flights(scene, np.random.default_rng(3))
    places = earth_centred(flights.places)
    velocity = np.diff(places, axis=0)
    speed, acceleration = np.linalg.norm(velocity, axis=2), np.diff(velocity, axis=0)
    assert (speed > 119.9).all()
    assert (speed < 260.9).all()
    hardest = np.linalg.norm(acceleration, axis=2).max(axis=0)
    # 30 degrees of bank, a pull, and what the earth bends; straight flights only the last
    assert 2.0 < hardest.max() < 7.5
    assert hardest.min() < 0.02
    height = flights.places[..., 2]
    assert height.min() > 900.0
    assert height.max() < 12_100.0
    climbing = np.abs(np.diff(height, axis=0)).max(axis=0)
    assert climbing.max() <= 15.0
    assert 0.2 < np.mean(climbing > 3.0) < 0.7


def test_controls_of_a_level_flight_are_none_and_of_others_start_gently():
    rng = np.random.default_rng(0)
    turn, climb = controls(LEVEL, 200.0, 5e3, 600, (1e3, 12e3), rng)
    assert not turn.any()
    assert not climb.any()
    turn, climb = controls(BOTH, 200.0, 5e3, 600, (1e3, 12e3), rng)
    assert 0.0 < np.abs(np.diff(turn)).max() <= np.deg2rad(3.0) / 6.0 + 1e-12
    assert 0.0 < np.abs(np.diff(climb)).max() <= 15.0 / 16.0 + 1e-12


def test_no_flight_before_its_first_second():
    with pytest.raises(ValueError, match="outside"):
        one(10).at(np.array([0]), np.array([-1.0]))
