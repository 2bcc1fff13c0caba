"""Gibbs sampling with biases that drift, beside draws given the weights of the mode."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from probreg.posterior.tracks import draw_drift, evidence_at, fit_tracks
from probreg.problems.recording.knots import Knots
from probreg.samplers.tracks import GibbsTracks
from probreg.sensors.drifts import known_drifts
from tests.posterior.traffic_tracks import model_of
from tests.statistical.traffic_runs import draw, drifted, step_path, walk_path

NAME = "radar1.azimuth"
PATHS = {"walk": walk_path(3, np.deg2rad(0.05), 400.0), "steps": step_path(3, 3e-3, 220.0)[1]}


def drifting_fit(kind, reports=3_000):
    drawn = drifted(draw(3, reports=reports, outlier_share=0.05), NAME, PATHS[kind])
    model, names = model_of(drawn.recording, drawn.setup)
    time = drawn.recording.time
    knots = Knots(len(names), (names.index(NAME),), np.linspace(time[0], time[-1], 9))
    model = replace(
        model,
        reports=replace(model.reports, knots=knots),
        drifts=((known_drifts()[kind], 0.002),),
    )
    return fit_tracks(model)


@pytest.mark.parametrize("kind", ["walk", "steps"])
def test_chains_agree_with_draws_given_the_weights(kind):
    """Weights move little: standard deviations agree to a tenth, means to a quarter of them."""
    fit = drifting_fit(kind)
    assert fit.point.spreads is not None
    rng = np.random.default_rng(1)
    fast = draw_drift(fit.model.drift, evidence_at(fit), fit.point.spreads, 4_000, rng)
    chains = GibbsTracks().sample(fit, 100, 2, rng)
    sd = fast.theta.std(axis=0)
    assert np.abs((chains.mean - fast.theta.mean(axis=0)) / sd).max() < 0.25
    np.testing.assert_allclose(chains.sd / sd, 1.0, atol=0.15)


def test_same_generator_same_draws():
    fit = drifting_fit("walk", 800)
    one, other = (GibbsTracks().sample(fit, 4, 1, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one.theta, other.theta)
    assert one.theta.shape == (1, 4, 5 + 9)
