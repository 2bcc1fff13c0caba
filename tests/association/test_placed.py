"""How far reports may be from their targets, against scatter, displacement and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from probreg import BearingSensor, PositionSensor, Radar2D, Radar3D, Tracker2D
from probreg.association._placed import _reach, _Said, place
from probreg.association._spots import Spots, between
from probreg.recordings import Recording, Setup
from probreg.sensors import Height
from probreg.sensors.axes import PolarAxes
from probreg.sensors.terms import known_terms

GATE_M = 100.0
HERE = np.array([5e3, -2e3])
AT = np.array([[30e3, 12e3], [-8e3, 40e3], [1e3, -25e3]])
LEVEL = {
    "radar": Radar2D((2e3, 1e3), 40.0, 2e-3, "s", from_north=True),
    "tracker": Tracker2D((2e3, 1e3), 60.0, "s"),
    "position": PositionSensor(((900.0, 200.0), (200.0, 400.0)), "s"),
}


def placed(sensor, at, own, *, biases=None, theta=None):
    """Noise-free reports of targets (n, d) by one sensor, placed."""
    n = len(at)
    recording = Recording(
        (sensor,),
        np.zeros(n, dtype=int),
        np.arange(float(n)),
        sensor.to_report(at, own),
        np.zeros(n, dtype=int),
        own_position=own,
    )
    # a recording needs some unknown; that of the prior is what widens the gates
    setup = Setup((sensor,), {"s": biases or sensor.bias_names[:1]}, gate_m=GATE_M)
    return place(recording, setup, theta)


@pytest.mark.parametrize("name", LEVEL)
def test_gates_widen_by_six_standard_deviations_of_the_places(name):
    sensor, n = LEVEL[name], 20_000
    rng = np.random.default_rng(4)
    own = np.tile(HERE, (len(AT), 1))
    found = placed(sensor, AT, own, theta=np.zeros(1))
    for at, where, gate in zip(AT, found.spots.where, found.gate, strict=True):
        np.testing.assert_allclose(where, at, atol=1.0)
        many, there = np.tile(at, (n, 1)), np.tile(HERE, (n, 1))
        noisy = sensor.to_report(many, there) + sensor.sample_noise(rng, n, many - HERE)
        spread = sensor.to_cartesian(noisy, there).var(axis=0).sum()
        # 20000 draws of one component at least: 1 % standard error of the variance
        assert gate**2 - GATE_M**2 == pytest.approx(36.0 * spread, rel=0.05)


@pytest.mark.parametrize("name", LEVEL)
def test_unknown_biases_widen_gates_by_how_they_move_places(name):
    sensor = LEVEL[name]
    own = np.tile(HERE, (len(AT), 1))
    terms = [t for n, t in known_terms(sensor).items() if n in sensor.bias_names]
    known = placed(sensor, AT, own, biases=sensor.bias_names, theta=np.zeros(len(terms)))
    unknown = placed(sensor, AT, own, biases=sensor.bias_names)
    reports = sensor.to_report(AT, own)
    moved = 0.0
    for term in terms:
        step = 1e-3 * term.prior_sd * term.column(reports)
        gap = sensor.to_cartesian(reports + step, own) - sensor.to_cartesian(reports, own)
        moved = moved + 4.0 * np.sum((1e3 * gap) ** 2, axis=1)
    np.testing.assert_allclose(unknown.gate**2 - known.gate**2, moved, rtol=1e-3)


def test_an_elevation_counts_vertically():
    radar = Radar3D((0.0, 0.0, 0.0), 1.0, 1e-6, 0.01, "s")
    at = np.array([[30e3, 40e3, 2e3]])
    found = placed(radar, at, np.zeros((1, 3)), theta=np.zeros(1))
    # an elevation that is off moves a target by its height horizontally
    level = 6.0 * np.array([1.0, 1e-6 * 50e3, 0.01 * 2e3])
    assert found.gate[0] ** 2 == pytest.approx(GATE_M**2 + level @ level, rel=0.01)
    assert found.spots.room[0] == pytest.approx(300.0 + 6.0 * 0.01 * 50e3, rel=0.01)
    np.testing.assert_allclose(found.spots.height, at[:, 2], rtol=1e-3)


@pytest.mark.parametrize("share", [0.5, 1.0, 2.0])
def test_bearings_fit_within_the_gate_seen_from_the_sensor(share):
    sigma, far = 3e-3, 20e3
    eye = BearingSensor(sigma, "s", from_north=True)
    at = HERE + far * np.array([[np.cos(0.4), np.sin(0.4)]])
    found = placed(eye, at, HERE[None], theta=np.zeros(1))
    limit = np.hypot(GATE_M, 6.0 * sigma * far)
    turn = 0.4 + share * limit / far
    there = HERE + far * np.array([[np.cos(turn), np.sin(turn)]])
    nothing = np.full(1, np.nan)
    away = found.misfit(np.array([0]), Spots(there, nothing, nothing))
    np.testing.assert_allclose(away, share, rtol=1e-6)


def test_bearings_wrap():
    eye = BearingSensor(1e-3, "s")
    found = placed(eye, np.array([[-20e3, -1.0]]), np.zeros((1, 2)), theta=np.zeros(1))
    nothing = np.full(1, np.nan)
    away = found.misfit(np.array([0]), Spots(np.array([[-20e3, 1.0]]), nothing, nothing))
    assert away[0] < 0.05


def test_heights_speak_only_where_both_are_known():
    where = np.zeros((4, 3))
    low = Spots(where, np.array([3e3, 3e3, np.nan, 3e3]), np.array([300.0, 300.0, np.nan, 900.0]))
    high = Spots(where, np.array([3.5e3, 4e3, 4e3, 4e3]), np.full(4, 300.0))
    np.testing.assert_array_equal(low.elsewhere(high), [False, True, False, False])
    np.testing.assert_array_equal(low.away(high), np.zeros(4))


def test_between_reports_targets_are_on_straight_lines():
    time = np.array([0.0, 2.0, 10.0])
    where = np.outer(time, [100.0, -50.0, 5.0])
    spots = Spots(where, where[:, 2], np.array([1.0, 2.0, 3.0]))
    at = np.array([1.0, 6.0, 10.5, 12.0])
    found, near = between(time, spots, at, 3.0)
    np.testing.assert_allclose(found.where, np.outer(at, [100.0, -50.0, 5.0]))
    np.testing.assert_allclose(found.height, 5.0 * at)
    np.testing.assert_array_equal(found.room, [2.0, 3.0, 3.0, 3.0])
    np.testing.assert_array_equal(near, [True, True, True, False])
    assert not between(time, spots, at, 2.0)[1][1:].any()  # a gap of 8 s is too long
    once, near = between(time[:1], spots.take(np.array([0])), np.array([0.1, 1.0]), 3.0)
    np.testing.assert_array_equal(near, [True, False])
    np.testing.assert_array_equal(once.where, np.zeros((2, 3)))


@pytest.mark.parametrize("slant", [14e3, 20e3, 40e3, 80e3, 200e3])
def test_a_guessed_height_widens_gates_by_what_it_does_to_places(slant):
    # oracle: the same report placed at other heights
    axes = PolarAxes(np.zeros(3), ("range", "azimuth"))
    radar = Radar2D((0.0, 0.0), 1e-3, 1e-9, "s")
    reports = np.array([[slant, 0.3]])
    guess, others = 8e3, np.array([3e3, 5e3, 9e3, 13e3])
    where = axes.place(reports, np.array([guess]))
    there = axes.place(np.tile(reports, (4, 1)), others)
    worst = np.linalg.norm((there - where)[:, :2], axis=1).max()
    said = [_Said(radar, np.array([0]), reports, [])]
    spots, reach = _reach(said, [axes], where, np.zeros((1, 3)), np.full(1, np.nan))
    assert np.isnan(spots.height[0])
    # nearer than 15 km the highest are not found: the limit is 5 km
    assert 0.7 * worst < reach[0] < 1.3 * worst
    told, known = _reach(said, [axes], where, np.zeros((1, 3)), np.full(1, 50.0))
    assert known[0] < 0.01
    assert told.room[0] == pytest.approx(350.0)
    assert told.height[0] == where[0, 2]


def test_heights_that_came_along_are_no_reports_of_their_own():
    radar = Radar3D((0.0, 0.0, 0.0), 20.0, 1e-3, 1e-3, "s")
    at = np.array([[30e3, 40e3, 2e3], [30e3, 40e3, 2e3], [30e3, 41e3, 2e3]])
    values = radar.to_report(at)
    values[1] = [2e3, np.nan, np.nan]
    sensor, beside = np.array([0, 1, 0]), np.array([0, 0, 2])
    sensors = (radar, Height(30.0))
    none = np.full(3, -1)
    recording = Recording(sensors, sensor, np.zeros(3), values, none, beside=beside)
    found = place(recording, Setup(sensors, {"s": ("range",)}), np.zeros(1))
    np.testing.assert_array_equal(found.judged, [True, False, True])
    assert np.isnan(found.spots.where[1]).all()
    assert found.reports.size == 0
