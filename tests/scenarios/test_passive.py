"""The bearings-only scenes: geometry, outliers and noise as the papers have them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.scenarios import rekf, rrtls


def error(data, truth, sigma_deg):
    return (data.bearing - truth.bearing - truth.bias) / np.deg2rad(sigma_deg)


def draw(module, scene, seed=1):
    return module.simulate(scene, np.random.default_rng(seed))


def test_the_aircraft_of_the_filter_paper():
    data, truth = draw(rekf, rekf.RekfScene())
    assert len(data) == 201
    np.testing.assert_allclose(data.own_position[[0, 1, 200]], [[0, 0], [600, 0], [120e3, 0]])
    np.testing.assert_allclose(truth.emitter, [5e3, 10e3])
    np.testing.assert_allclose(np.tan(truth.bearing[0]), 2.0)
    assert truth.bearing[20] > np.pi / 2 > truth.bearing[0]  # passed
    assert not truth.outlier.any()


def test_outlier_readings_share_their_noise():
    scenes = {r: rekf.RekfScene(outliers=r) for r in rekf.READINGS}
    drawn = {r: draw(rekf, s) for r, s in scenes.items()}
    plain = error(*drawn["none"], 0.1)
    at = np.flatnonzero(drawn["random"][1].outlier)
    np.testing.assert_array_equal(at, [*range(100, 111), 130, 140, 160])
    size = np.array([5.0] * 11 + [10.0, 20.0, 25.0])
    np.testing.assert_allclose(error(*drawn["one_sided"], 0.1)[at], plain[at] + size)
    np.testing.assert_allclose(error(*drawn["random"], 0.1)[at], plain[at] * size)
    rest = np.setdiff1d(np.arange(201), at)
    for reading in rekf.READINGS:
        np.testing.assert_allclose(error(*drawn[reading], 0.1)[rest], plain[rest], atol=1e-9)


def test_the_distant_emitter_and_its_outliers():
    clean = draw(rrtls, rrtls.RrtlsScene())
    table = draw(rrtls, rrtls.RrtlsScene(outliers=rrtls.TABLE))
    added = error(*table, 0.6) - error(*clean, 0.6)
    point = np.arange(1, 201)
    np.testing.assert_allclose(added[(point >= 101) & (point <= 110)], -3.0)
    np.testing.assert_allclose(added[np.isin(point, [120, 130, 140, 150])], -30.0)
    np.testing.assert_allclose(added[point == 180], -60.0)
    assert table[1].outlier.sum() == 15
    np.testing.assert_allclose(np.diff(clean[0].own_position, axis=0), [[300.0, 0.0]] * 199)


def test_contamination_strikes_its_share_of_points():
    counts = [
        draw(rrtls, rrtls.RrtlsScene(contamination=0.13), seed)[1].outlier.sum()
        for seed in range(200)
    ]
    # 40 000 draws, limit 4.5 standard errors: false alarm rate 7e-6
    assert abs(np.mean(counts) / 200 - 0.13) < 4.5 * np.sqrt(0.13 * 0.87 / 40_000)


@pytest.mark.parametrize("module", [rekf, rrtls])
def test_a_bias_adds_to_every_report(module):
    scene = (rekf.RekfScene if module is rekf else rrtls.RrtlsScene)()
    plain, _ = draw(module, scene)
    biased, truth = draw(module, dataclasses.replace(scene, bias_deg=0.5))
    np.testing.assert_allclose(biased.bearing - plain.bearing, np.deg2rad(0.5))
    assert truth.bias == np.deg2rad(0.5)


def test_wrong_settings_are_refused():
    with pytest.raises(InvalidInputError, match="outliers is 'some'"):
        rekf.RekfScene(outliers="some")
    with pytest.raises(InvalidInputError, match="contamination"):
        rrtls.RrtlsScene(contamination=1.0)
    with pytest.raises(InvalidInputError, match="outside the recording"):
        draw(rrtls, rrtls.RrtlsScene(outliers=rrtls.TABLE, points=100))
