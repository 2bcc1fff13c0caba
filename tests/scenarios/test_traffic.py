"""Simulated air traffic: motion, noise, biases and wrong identities are what the scene says."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import binomtest, chi2

from probreg.errors import InvalidInputError
from probreg.scenarios import _flights
from probreg.scenarios.traffic import TrafficScene, radars, simulate
from probreg.sensors import PositionSensor
from probreg.sensors.geometry import wrap_angle

BIASES = {
    "radar1.range": 120.0,
    "radar1.azimuth": 5e-3,
    "radar2.range_gain": 2e-3,
    "radar3.time": -0.7,
}


def draw(seed=3, **scene):
    return simulate(TrafficScene(**scene), np.random.default_rng(seed))


def test_an_arc_is_what_integration_of_the_turn_gives():
    speed, heading, rate = 200.0, 0.7, -0.02
    path = solve_ivp(
        lambda _, s: [speed * np.cos(s[2]), speed * np.sin(s[2]), rate],
        (0.0, 90.0),
        [0.0, 0.0, heading],
        rtol=1e-10,
    )
    step = _flights.advance(*(np.array(v) for v in (speed, heading, rate, 90.0)))
    np.testing.assert_allclose(step, path.y[:2, -1], rtol=1e-7)


def test_aircraft_fly_without_jumps_at_their_speed_and_within_the_turn_limit():
    flights = _flights.draw_flights(3, 4_000.0, np.random.default_rng(0))
    time = np.arange(0.0, 4_000.0, 0.5)
    for slot in range(3):
        slots = np.full(time.shape, slot)
        where, flight = flights.position(slots, time), flights.flight(slots, time)
        same = flight[2:] == flight[:-2]
        speed = np.linalg.norm(np.diff(where, axis=0), axis=1) / 0.5
        np.testing.assert_allclose(speed[1:][same], flights.speed[flight[2:]][same], rtol=1e-4)
        bend = np.linalg.norm(np.diff(where, n=2, axis=0), axis=1) / 0.25
        assert bend[same].max() < 1.01 * _flights.TURN_M_S2
        assert len(np.unique(flight)) >= 4


@pytest.mark.parametrize("dim", [2, 3])
def test_reports_are_truth_plus_bias_plus_noise(dim):
    recording, _, truth = draw(reports=6_000, sensors=radars(dim=dim), biases=BIASES)
    assert len(recording) == 6_000
    for k, sensor in enumerate(recording.sensors):
        rows = recording.sensor == k
        true = sensor.to_report(truth.positions[rows])
        error = recording.values[rows] - true
        error[:, 0] -= BIASES.get(f"{sensor.name}.range", 0.0)
        error[:, 0] -= BIASES.get(f"{sensor.name}.range_gain", 0.0) * true[:, 0]
        error[:, 1] = wrap_angle(error[:, 1] - BIASES.get(f"{sensor.name}.azimuth", 0.0))
        scaled = error / sensor.sigmas
        # a false alarm in 1e6 draws of the noise
        low, high = chi2.ppf([5e-7, 1 - 5e-7], scaled.size)
        assert low < (scaled**2).sum() < high
        assert np.abs(scaled.mean(axis=0)).max() * np.sqrt(len(scaled)) < 5.0
        late = recording.time[rows] - truth.time[rows]
        np.testing.assert_allclose(late, BIASES.get(f"{sensor.name}.time", 0.0), atol=1e-9)


def cross_pairs(recording):
    """For each report of sensor 0 the nearest in time of sensor 1 under the same identity."""
    pairs = []
    for row in np.flatnonzero(recording.sensor == 0):
        same = (recording.sensor == 1) & (recording.target == recording.target[row])
        other = np.flatnonzero(same & (np.abs(recording.time - recording.time[row]) < 10.0))
        if other.size:
            nearest = np.argmin(np.abs(recording.time[other] - recording.time[row]))
            pairs.append((row, other[nearest]))
    return np.array(pairs)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5])
def test_the_stated_share_of_cross_sensor_pairs_is_wrong(share):
    recording, _, truth = draw(reports=5_000, wrong_share=share)
    pairs = cross_pairs(recording)
    wrong = truth.target[pairs[:, 0]] != truth.target[pairs[:, 1]]
    if share == 0.0:
        assert not wrong.any()
        assert not truth.wrong.any()
        return
    # pairs share reports, so a third of them are worth counting; and the share is approximate
    interval = binomtest(wrong.sum() // 3, len(wrong) // 3).proportion_ci(0.9999)
    assert interval.low < share < interval.high
    assert len(pairs) > 1_000


def test_outliers_have_ten_times_the_noise():
    recording, _, truth = draw(reports=20_000, outlier_share=0.1, biases={})
    assert 0.09 < truth.outlier.mean() < 0.11
    error = np.concatenate(
        [
            (recording.values[rows] - sensor.to_report(truth.positions[rows]))[:, 0] / 50.0
            for sensor, rows in (
                (s, np.flatnonzero(recording.sensor == k)) for k, s in enumerate(recording.sensors)
            )
        ]
    )
    marked = np.concatenate([truth.outlier[recording.sensor == k] for k in range(3)])
    np.testing.assert_allclose([error[marked].std(), error[~marked].std()], [10, 1], rtol=0.08)


def test_radars_are_asynchronous_and_never_see_what_is_above_them():
    recording, _, truth = draw(reports=20_000)
    for k, (sensor, scan) in enumerate(zip(recording.sensors, (4.0, 5.0, 6.0), strict=True)):
        rows = recording.sensor == k
        one = np.diff(truth.time[rows & (truth.target == np.bincount(truth.target).argmax())])
        turns = one / scan
        assert one.size > 10
        np.testing.assert_allclose(turns, turns.round(), atol=1e-6)
        away = np.hypot(*(truth.positions[rows] - sensor.position).T)
        assert away.min() > 2_000.0


def test_a_position_sensor_is_a_reference_and_the_engineer_is_not_told_the_biases():
    gnss = PositionSensor(((400.0, 0.0), (0.0, 400.0)), "adsb")
    recording, setup, truth = draw(reports=900, sensors=(*radars(2), gnss), scan_s=(4.0, 5.0, 1.0))
    assert setup.biases == {
        "radar1": ("range", "azimuth"),
        "radar2": ("range", "azimuth"),
        "adsb": (),
    }
    assert set(truth.bias) == {f"radar{k}.{t}" for k in (1, 2) for t in ("range", "azimuth")}
    assert np.bincount(recording.sensor)[2] > 500


def test_the_same_seed_gives_the_same_recording_and_another_seed_another():
    one, two, other = (draw(seed=s, reports=500)[0] for s in (1, 1, 2))
    np.testing.assert_array_equal(one.values, two.values)
    assert not np.array_equal(one.values, other.values)


def test_a_long_recording_keeps_aircraft_in_range():
    recording, *_ = draw(reports=200_000, sensors=radars(2), aircraft=10)
    halves = np.array_split(np.arange(len(recording)), 2)
    spans = [np.ptp(recording.time[rows]) for rows in halves]
    np.testing.assert_allclose(spans[0], spans[1], rtol=0.05)
    assert len(recording.labels) > 50


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"reports": 0}, "must be 1 or more"),
        ({"wrong_share": 1.0}, "shares"),
        ({"detection": 0.0}, "probability"),
        ({"aircraft": 1, "wrong_share": 0.1}, "two aircraft"),
        ({"scan_s": (0.0,)}, "above zero"),
        ({"biases": {"radar9.range": 1.0}}, "radar9.range"),
        ({"biases": {"radar1.elevation": 1.0}}, "radar1.elevation"),
        ({"sensors": (*radars(1), *radars(1, dim=3))}, "one dimension"),
    ],
)
def test_a_scene_that_cannot_be_is_refused(change, message):
    with pytest.raises(InvalidInputError, match=message):
        TrafficScene(**change)


def test_radars_that_see_nothing_say_so():
    with pytest.raises(InvalidInputError, match="max_range_m"):
        draw(reports=2_000, max_range_m=2_100.0)
    with pytest.raises(InvalidInputError, match="dim is 4"):
        radars(dim=4)
