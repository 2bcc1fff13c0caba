"""Drifting traffic: reports carry the bias of their instant, and walks spread as they say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from probreg.errors import InvalidInputError
from probreg.scenarios import traffic
from probreg.scenarios.drifting import DriftingScene, Ramp, Step, Walk, simulate
from probreg.sensors.geometry import wrap_angle

SCENE = traffic.TrafficScene(reports=2_000, outlier_share=0.05, wrong_share=0.1)


def draw(drift, seed=4):
    return simulate(DriftingScene(SCENE, drift), np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("drift", "at"),
    [
        (Step(40.0, 3e-3), lambda t: np.where(t < 40.0, 0.0, 3e-3)),
        (Ramp(20.0, 0.36), lambda t: np.clip(t - 20.0, 0.0, None) * 1e-4),
    ],
)
def test_reports_differ_from_still_ones_by_the_drift_at_their_time(drift, at):
    still, _, known = traffic.simulate(SCENE, np.random.default_rng(4))
    moved, _, truth = draw({"radar2.azimuth": drift})
    own = still.sensor == 1
    added = wrap_angle(moved.values - still.values)
    np.testing.assert_allclose(added[own, 1], at(known.time[own]), atol=1e-12)
    assert not np.any(moved.values[~own] != still.values[~own])
    np.testing.assert_array_equal(moved.values[:, 0], still.values[:, 0])
    bias = truth.bias("radar2.azimuth", np.array([50.0]))
    np.testing.assert_allclose(bias, known.bias["radar2.azimuth"] + at(np.array([50.0])))


def test_a_walk_gains_its_variance_in_a_minute():
    steps = []
    for seed in range(5):
        _, _, truth = draw({"radar1.range": Walk(20.0), "radar3.azimuth": Walk(1e-3)}, seed)
        for name, sd in (("radar1.range", 20.0), ("radar3.azimuth", 1e-3)):
            steps.append(np.diff(truth.drift[name]) / (sd * np.sqrt(1.0 / 60.0)))
    every = np.concatenate(steps)
    # one false alarm in a thousand
    low, high = chi2(len(every)).ppf([5e-4, 1.0 - 5e-4])
    assert low < (every**2).sum() < high


def test_unknown_components_and_walks_that_do_not_move_are_refused():
    with pytest.raises(InvalidInputError, match=r"radar1\.height"):
        DriftingScene(SCENE, {"radar1.height": Walk(1.0)})
    with pytest.raises(InvalidInputError, match="per_root_minute"):
        Walk(0.0)
