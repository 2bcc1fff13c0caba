from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.scenarios.ralad import CASES, RaladScene, simulate


@pytest.fixture(scope="module", params=[0, 1, 2])
def drawn(request):
    scene = CASES[request.param]
    return scene, *simulate(scene, np.random.default_rng(3))


def test_numbers_of_the_paper():
    assert CASES[1] == RaladScene(4, 0.40, 0.05, 50.0)
    assert CASES[2] == RaladScene(6, 0.50, 0.10, 50.0)
    np.testing.assert_allclose(
        CASES[1].bias, [20, -8.7266e-3, 8.7266e-3, -20, 8.7266e-3, -8.7266e-3], rtol=1e-4
    )
    first, second = CASES[1].sensors
    assert first.position == (-4000.0, -4000.0, 0.0)
    assert second.position == (4000.0, 4000.0, 0.0)
    np.testing.assert_allclose(first.sigmas, [30.0, np.deg2rad(0.5), np.deg2rad(0.5)])


def test_targets_fly_level_through_the_origin_from_twenty_kilometres(drawn):
    scene, _data, truth = drawn
    own = truth.positions[0].reshape(scene.scans, scene.targets, 3)
    height = own[0, :, 2]
    np.testing.assert_allclose(own[:, :, 2], np.broadcast_to(height, own.shape[:2]))
    assert ((height >= 2000) & (height <= 3000)).all()
    lead = own[:, : scene.targets - scene.pairs]
    start = np.hypot(lead[0, :, 0], lead[0, :, 1])
    assert ((start >= 19_900) & (start <= 20_000)).all()
    step = np.linalg.norm(np.diff(own, axis=0), axis=2)
    np.testing.assert_allclose(step, 25.0, rtol=1e-6)
    nearest = np.hypot(lead[:, :, 0], lead[:, :, 1]).min(axis=0)
    assert (nearest < 30.0).all()


def test_parallel_tracks_are_1500_m_beside_at_the_same_height(drawn):
    scene, _data, truth = drawn
    own = truth.positions[0].reshape(scene.scans, scene.targets, 3)
    for first in range(scene.pairs):
        apart = own[:, scene.targets - scene.pairs + first] - own[:, first]
        np.testing.assert_allclose(np.linalg.norm(apart, axis=1), 1500.0, rtol=1e-9)
        np.testing.assert_allclose(apart[:, 2], 0.0, atol=1e-9)


def test_exchanges_are_the_stated_share_and_truth_follows_the_report(drawn):
    scene, _data, truth = drawn
    exchanged = truth.exchanged.reshape(scene.scans, scene.targets)
    expected = np.zeros(scene.targets)
    expected[: scene.pairs] = expected[scene.targets - scene.pairs :] = scene.exchanged_share
    if scene.pairs == 0:
        expected[:] = 0.0
    np.testing.assert_allclose(exchanged.mean(axis=0), expected, atol=1e-9)
    distance = np.linalg.norm(truth.positions[0] - truth.positions[1], axis=1)
    np.testing.assert_allclose(distance[truth.exchanged], 1500.0, rtol=1e-9)
    np.testing.assert_allclose(distance[~truth.exchanged], 0.0, atol=1e-9)


def test_noise_is_nominal_with_a_share_of_outliers_of_fifty_sigma(drawn):
    # errors in sigmas: variance of 192 000 components at 5 standard errors, 6 groups
    scene, data, truth = drawn
    for s, sensor in enumerate(data.sensors):
        errors = (
            data.values[s] - sensor.to_report(truth.positions[s]) - truth.bias[3 * s : 3 * s + 3]
        )
        errors[:, 1] = (errors[:, 1] + np.pi) % (2 * np.pi) - np.pi
        outlier = truth.outlier[:, 3 * s : 3 * s + 3]
        assert abs(outlier.mean() - scene.outlier_rate) < 5 * 0.31 / np.sqrt(outlier.size)
        sigmas = errors / sensor.sigmas
        good = sigmas[~outlier]
        assert abs(good.var() - 1.0) < 5 * np.sqrt(2 / good.size)
        ranges = sigmas[:, 0][outlier[:, 0]]
        if ranges.size:
            assert abs(ranges.std() / 50.0 - 1.0) < 5 / np.sqrt(2 * ranges.size)


def test_same_seed_same_scene():
    scene = dataclasses.replace(CASES[2], scans=5)
    one, two = (simulate(scene, np.random.default_rng(1))[0] for _ in range(2))
    np.testing.assert_array_equal(one.values[1], two.values[1])
    np.testing.assert_array_equal(one.tracks, two.tracks)


def test_impossible_scenes_are_refused():
    with pytest.raises(InvalidInputError, match="21 pairs"):
        RaladScene(pairs=21)
    with pytest.raises(InvalidInputError, match="shares"):
        RaladScene(outlier_rate=5.0)


def test_biases_drift_by_their_rate_and_reports_carry_them():
    # 799 steps: variances within 4.4 standard errors of a chi-square, six of them
    scene = RaladScene(drift_range_m=2.0, drift_angle_deg=0.05, outlier_rate=0.0)
    data, truth = simulate(scene, np.random.default_rng(4))
    np.testing.assert_array_equal(truth.path[0], scene.bias)
    steps = np.diff(truth.path, axis=0) / np.sqrt(0.1 * scene.drift_rate)
    assert np.abs((steps**2).mean(axis=0) - 1.0).max() < 4.4 * np.sqrt(2.0 / 799)
    own = data.values[0] - scene.sensors[0].to_report(truth.positions[0])
    left = (own - truth.path[np.repeat(np.arange(800), 40), :3]) / scene.sensors[0].sigmas
    assert np.abs(left.mean(axis=0)).max() < 4.4 / np.sqrt(32_000)
