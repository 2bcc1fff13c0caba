"""Which constant bias drifts, and fits with knots beside fits without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from probreg.motion.tracks import eliminate_drifting, eliminate_paths
from probreg.posterior.tracks import (
    as_constant,
    bias_scores,
    fit_tracks,
    local_covariance,
    score_drift,
    score_missing,
    score_spread,
    some_targets_say,
    telling_targets,
)
from probreg.problems.recording.knots import Knots
from probreg.sensors.drifts import known_drifts
from probreg.sensors.terms import known_terms
from tests.posterior.traffic_tracks import model_of
from tests.statistical.traffic_runs import draw, drifted, walk_path

NAME = "radar2.azimuth"
WALK = known_drifts()["walk"]


def fitted(drawn, drifting=(), scale=0.002, knots=8):
    model, names = model_of(drawn.recording, drawn.setup)
    if drifting:
        time = drawn.recording.time
        places = np.linspace(time[0], time[-1], knots)
        at = Knots(len(names), tuple(sorted(names.index(name) for name in drifting)), places)
        drifts = ((WALK, scale),) * len(drifting)
        model = replace(model, reports=replace(model.reports, knots=at), drifts=drifts)
    return fit_tracks(model), names


@pytest.fixture(scope="module")
def still():
    return fitted(draw(7, reports=4_000))


@pytest.fixture(scope="module")
def moving():
    return draw_moving(7)


def draw_moving(seed):
    drawn = draw(seed, reports=4_000)
    return drifted(drawn, NAME, walk_path(seed, np.deg2rad(0.06), 400.0))


def test_the_bias_that_walks_is_named_and_no_other(still, moving):
    scale = 0.1 * np.sqrt(np.diag(still[0].model.prior.covariance))
    quiet = score_drift(still[0], WALK, scale)
    assert quiet.gain.max() < 5.0
    assert (quiet.constant > 0.1).all()
    fit, names = fitted(moving)
    loud = score_drift(fit, WALK, scale)
    k = names.index(NAME)
    assert loud.gain[k] > 12.0
    assert np.delete(loud.gain, k).max() < 0.2 * loud.gain[k]
    assert loud.constant[k] < 1e-4
    # what drifts in a fit is no longer tested, and takes its part from the others
    after, _ = fitted(moving, [NAME])
    left = score_drift(after, WALK, scale)
    assert left.gain[k] == 0.0
    assert left.gain.max() < 5.0


def test_a_drift_so_small_that_it_is_none_gives_the_constant_fit(still):
    """The oracle of the whole search: the other engine, on the same reports."""
    fit, _ = still
    drawn = draw(7, reports=4_000)
    tied, _ = fitted(drawn, [NAME], scale=1e-12)
    np.testing.assert_allclose(tied.biases, fit.biases, atol=2e-3 * fit.sd.min())
    np.testing.assert_allclose(tied.bias_sd, fit.sd, rtol=1e-3)
    np.testing.assert_allclose(tied.weights, fit.weights, atol=1e-2)
    some = telling_targets(fit)[::2]
    np.testing.assert_array_equal(telling_targets(tied), telling_targets(fit))
    ours = tied.knots.averages(some_targets_say(tied, some))
    np.testing.assert_allclose(ours, some_targets_say(fit, some), atol=1e-2 * fit.sd.min())
    tie = tied.knots.constant
    scores = bias_scores(fit)
    np.testing.assert_allclose(bias_scores(tied) @ tie, scores, atol=1e-2 * np.abs(scores).max())
    where = np.array([3.0, 60.0])
    local = local_covariance(tied, where)
    np.testing.assert_allclose(local[1], fit.covariance, atol=2e-3 * np.abs(fit.covariance).max())
    terms = {"range_gain", "azimuth_sine"}
    named = [{0: known_terms(drawn.recording.sensors[0])[term]} for term in sorted(terms)]
    one, other = score_missing(tied, named), score_missing(fit, named)
    np.testing.assert_allclose(one.value, other.value, atol=2e-2 * other.sd.min())
    np.testing.assert_allclose(one.sd, other.sd, rtol=1e-2)
    np.testing.assert_allclose(score_spread(tied, named).z, score_spread(fit, named).z, atol=0.5)


def test_equations_with_one_column_a_bias_say_what_constants_say(moving):
    fit, _ = fitted(moving, [NAME, "radar1.range"])
    equations, knots = fit.point.tangent.equations, fit.knots
    motion = fit.model.motion(equations, fit.point.density, fit.point.constant_sd)
    columns = knots.num_static, len(knots.drifting)
    whole = eliminate_drifting(equations, motion, columns, knots.time, fit.point.weights)
    one = eliminate_paths(as_constant(fit), motion, knots.num_biases, fit.point.weights)
    tied = knots.constant.T @ whole.precision @ knots.constant
    np.testing.assert_allclose(tied, one.precision, rtol=1e-9, atol=1e-9 * one.precision.max())


def test_what_all_clocks_have_in_common_is_taken_out_at_every_knot():
    biases = {f"radar{k}.time": 0.1 * k for k in (1, 2, 3)}
    drawn = draw(8, reports=2_000, biases=biases)
    fit, _ = fitted(drawn, list(biases), scale=0.1)
    together, knots = fit.model.common_clocks, fit.knots
    np.testing.assert_allclose(together.T @ together, np.eye(len(knots.time)), atol=1e-12)
    at = [knots.places(bias) for bias in knots.drifting]
    # a common shift at one knot has its prior variance left, over the three of them
    common = np.array([fit.covariance[np.ix_(own, own)].mean() for own in np.transpose(at)])
    level = fit.model.prior.covariance[knots.drifting[0], knots.drifting[0]] / 3.0
    assert (common > 0.9 * level).all()
    some, _ = fitted(drawn, list(biases)[:1], scale=0.1)
    assert some.model.common_clocks.shape == (some.knots.size, 1)
