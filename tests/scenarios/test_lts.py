from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

from probreg.association import nearest_neighbours, wrong_pairs
from probreg.errors import InvalidInputError
from probreg.scenarios.lts import READINGS, LtsScene, simulate


def draw(scene, seed):
    return simulate(scene, np.random.default_rng(seed))


def test_numbers_of_the_paper():
    scene = READINGS["literal"]
    assert scene.centre_m == (0.0, 80e3)
    assert (scene.targets, scene.detection, scene.false_alarms) == (15, 0.96, 2.0)
    np.testing.assert_allclose(scene.bias, [1000.0, np.deg2rad(1), -1000.0, -np.deg2rad(1)])
    assert scene.sensors[1].position == (100e3, 0.0)
    assert scene.sensors[0].from_north


def test_bias_enters_the_polar_report_exactly_and_noise_the_position():
    scene = LtsScene(sigma_m=0.0, detection=1.0, false_alarms=0.0)
    data, truth = draw(scene, 1)
    for reports, target, bias in zip(data, truth.targets, scene.bias.reshape(2, 2), strict=True):
        clean = reports.sensor.to_report(truth.positions[target])
        np.testing.assert_allclose(reports.values, clean + bias, atol=1e-6)


def test_noise_is_cartesian_and_the_same_draws_serve_every_level():
    quiet, _ = draw(LtsScene(sigma_m=0.0), 3)
    one, truth_one = draw(LtsScene(sigma_m=50.0), 3)
    two, truth_two = draw(LtsScene(sigma_m=100.0), 3)
    for a, b, c in zip(quiet, one, two, strict=True):
        np.testing.assert_allclose(
            c.positions() - a.positions(), 2.0 * (b.positions() - a.positions()), atol=1e-5
        )
    np.testing.assert_array_equal(truth_one.targets[0], truth_two.targets[0])


def test_detections_and_false_alarms_follow_their_laws():
    # 400 frames x 2 sensors: binomial and Poisson totals at 4.5 standard deviations
    frames = [draw(LtsScene(), seed)[1] for seed in range(400)]
    seen = sum(int((t >= 0).sum()) for truth in frames for t in truth.targets)
    false = sum(int((t < 0).sum()) for truth in frames for t in truth.targets)
    assert abs(seen - 12_000 * 0.96) < 4.5 * np.sqrt(12_000 * 0.96 * 0.04)
    assert abs(false - 1_600) < 4.5 * np.sqrt(1_600)
    x = np.concatenate([truth.positions for truth in frames])
    assert stats.kstest(x[:, 0], "uniform", (-20e3, 40e3)).pvalue > 1e-5
    assert stats.kstest(x[:, 1], "uniform", (60e3, 40e3)).pvalue > 1e-5


def test_right_pairs_join_the_same_target():
    _, truth = draw(LtsScene(), 5)
    pairs = truth.right_pairs()
    assert not wrong_pairs(pairs, *truth.targets).any()
    assert len(pairs) == len(truth.common())


@pytest.mark.parametrize(("reading", "expected"), [("literal", 0.21), ("symmetric", 0.145)])
def test_share_of_wrong_pairs(reading, expected):
    # 300 frames; the share of a frame has a standard deviation of about 0.14: 4.5 errors
    scene = dataclasses.replace(READINGS[reading], sigma_m=100.0)
    shares = []
    for seed in range(300):
        (a, b), truth = draw(scene, seed)
        pairs = nearest_neighbours(a.positions(), b.positions(), scene.gate_m, scene.objective)
        shares.append(wrong_pairs(pairs, *truth.targets).mean())
    assert np.mean(shares) == pytest.approx(expected, abs=4.5 * 0.14 / np.sqrt(300) + 0.005)


def test_impossible_scenes_are_refused():
    with pytest.raises(InvalidInputError, match="probability"):
        LtsScene(detection=1.2)
    with pytest.raises(InvalidInputError, match="zero or more"):
        LtsScene(sigma_m=-1.0)
