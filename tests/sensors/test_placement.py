"""Range, azimuth and elevation about a sensor's own axes: inverses, derivatives, attitudes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from probreg.sensors.geometry import azimuth_from_north, wrap_angle
from probreg.sensors.placement import Placement, attitude

POSITION = np.array([40e3, -70e3, -300.0])


def placement(seed=4):
    """Axes that are tilted far more than the earth tilts them."""
    return Placement(POSITION, Rotation.random(random_state=seed).as_matrix())


def targets(n=200, seed=5):
    rng = np.random.default_rng(seed)
    return rng.uniform((-2e5, -2e5, -5e3), (2e5, 2e5, 12e3), (n, 3))


def test_positions_come_back():
    placed, x = placement(), targets()
    np.testing.assert_allclose(placed.common(placed.local(x)), x, atol=1e-9)
    np.testing.assert_allclose(placed.positions(placed.polar(x)), x, atol=1e-8)
    np.testing.assert_array_equal(placed.sight(x).polar, placed.polar(x))


def test_derivatives_by_position_against_finite_differences():
    placed, x, step = placement(), targets(), 1.0
    sight = placed.sight(x)
    # directions are orthonormal and the levers are metres for one unit of a component
    gram = sight.directions @ np.swapaxes(sight.directions, 1, 2)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), gram.shape), atol=1e-14)
    for axis in range(3):
        move = step * np.eye(3)[axis]
        change = placed.polar(x + move) - placed.polar(x - move)
        change[:, 1] = wrap_angle(change[:, 1])
        scaled = sight.levers * change / (2.0 * step)
        np.testing.assert_allclose(sight.directions[:, :, axis], scaled, atol=2e-8)


def test_on_the_vertical_an_azimuth_says_nothing_and_nothing_is_nan():
    placed = Placement(POSITION)
    sight = placed.sight(POSITION + np.array([[0.0, 0.0, 8e3]]))
    assert sight.levers[0, 1] == 0.0
    np.testing.assert_allclose(sight.directions[0, 0], [0.0, 0.0, 1.0], atol=1e-15)
    assert np.isfinite(sight.directions).all()


def test_clockwise_from_the_bow():
    # compass heading 60 degrees: what is due east is 30 degrees to starboard
    placed = Placement(np.zeros(3)).tilted(attitude(np.deg2rad(90.0 - 60.0)))
    seen = placed.polar(np.array([[1e3, 0.0, 0.0], [0.0, 1e3, 0.0]]))
    from_bow = np.rad2deg(azimuth_from_north(seen[:, 1]))
    np.testing.assert_allclose(from_bow, [30.0, -60.0], atol=1e-12)


@pytest.mark.parametrize(
    ("pitch", "roll", "seen", "elevation"),
    # bow up: what is ahead sinks; starboard down: what is to starboard rises
    [(0.1, 0.0, "ahead", -0.1), (0.0, 0.1, "right", 0.1), (0.0, 0.1, "ahead", 0.0)],
)
def test_signs_of_pitch_and_roll(pitch, roll, seen, elevation):
    heading = 0.7
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    right = np.array([np.sin(heading), -np.cos(heading), 0.0])
    placed = Placement(np.zeros(3)).tilted(attitude(heading, pitch, roll))
    polar = placed.polar(5e3 * {"ahead": ahead, "right": right}[seen])
    assert polar[2] == pytest.approx(elevation, abs=1e-12)


def test_attitudes_against_scipy():
    # forward, right, down and the angles of aeronautics, turned intrinsically z, y, x
    rng = np.random.default_rng(6)
    heading, pitch, roll = rng.uniform(-1.0, 1.0, (3, 50))
    compass = 0.5 * np.pi - heading
    body = Rotation.from_euler("ZYX", np.stack([compass, pitch, roll], axis=1)).as_matrix()
    swap = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    # body maps forward-right-down to north-east-down; both ends into right-forward-up
    expected = swap @ np.swapaxes(body, 1, 2) @ swap
    np.testing.assert_allclose(attitude(heading, pitch, roll), expected, atol=1e-14)
