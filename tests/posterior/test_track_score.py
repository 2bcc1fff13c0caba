"""Score tests of missing terms: they name the right one, and are what a fit with it finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.noise import Gaussian
from probreg.posterior.tracks import fit_tracks, score_missing, score_spread
from probreg.prior import GaussianPrior
from probreg.sensors.terms import known_terms
from tests.posterior.traffic_tracks import draw, model_of

TERMS = ("range_gain", "azimuth_sine", "azimuth_cosine", "time")
WRONG = {
    "radar2.range_gain": 1e-3,
    "radar1.time": 0.3,
    "radar3.time": -0.3,
}


def candidates_of(recording):
    names, found = [], []
    for s, sensor in enumerate(recording.sensors):
        own = known_terms(sensor)
        names += [f"{sensor.name}.{term}" for term in TERMS]
        found += [{s: own[term]} for term in TERMS]
    return names, found


def simulated(biases, seed=4):
    """A recording with these errors, and a model that knows of ranges and azimuths only."""
    usual = {f"radar{k}.{t}": v for k, t, v in ((1, "range", 50.0), (2, "azimuth", 2e-3))}
    recording, setup, _ = draw(seed, biases={**usual, **biases})
    asked = {s.name: ("range", "azimuth") for s in recording.sensors}
    model, _ = model_of(recording, replace(setup, biases=asked))
    return recording, model


@pytest.mark.parametrize("missing", WRONG)
def test_the_missing_term_is_named_first(missing):
    recording, model = simulated({missing: WRONG[missing]})
    names, candidates = candidates_of(recording)
    scores = score_missing(fit_tracks(model), candidates)
    assert names[int(np.argmax(scores.chi2))] == missing
    assert scores.chi2.max() > 50.0


def test_nothing_is_named_where_nothing_is_missing():
    recording, model = simulated({})
    _, candidates = candidates_of(recording)
    # twelve tests, one false alarm in ten thousand recordings
    assert score_missing(fit_tracks(model), candidates).chi2.max() < 19.0


def test_scores_are_what_a_fit_with_the_term_finds():
    missing = "radar2.range_gain"
    recording, model = simulated({missing: 1e-3})
    known = {"unknown": (frozenset(),) * 3, "acceleration_log_sd": 0.0, "acceleration": 2.0}
    model = replace(model, laws=(Gaussian(),) * 3, **known)
    term = known_terms(recording.sensors[1])["range_gain"]
    scores = score_missing(fit_tracks(model), [{1: term}])
    models = list(model.reports.models)
    models[1] = replace(models[1], terms=(*models[1].terms, (6, term)))
    sd = np.append(np.sqrt(np.diag(model.prior.covariance)), 1.0)
    wider = replace(
        model,
        reports=replace(model.reports, models=tuple(models), num_biases=7),
        prior=GaussianPrior.from_sd(sd),
    )
    fit = fit_tracks(wider)
    # the same but for where the equations are linearised
    np.testing.assert_allclose(scores.value[0], fit.theta[6], rtol=0.02)
    np.testing.assert_allclose(scores.sd[0], fit.sd[6], rtol=0.02)
    np.testing.assert_allclose(scores.chi2[0], (fit.theta[6] / fit.sd[6]) ** 2, rtol=0.05)


def test_a_term_that_the_model_has_says_nothing_more():
    recording, model = simulated({})
    own = known_terms(recording.sensors[0])
    free = replace(model, prior=GaussianPrior.from_sd(np.full(6, 1e6)))
    scores = score_missing(fit_tracks(free), [{0: own["range"]}])
    assert scores.chi2[0] == 0.0
    assert scores.sd[0] == np.inf


def test_candidates_of_no_sensor_are_refused():
    recording, model = simulated({})
    fit = fit_tracks(replace(model, acceleration_log_sd=0.0))
    term = known_terms(recording.sensors[0])["time"]
    for candidates, message in (
        ([], "at least one"),
        ([{}], "each with a sensor"),
        ([{7: term}], "of sensor 7; there are 3"),
    ):
        with pytest.raises(InvalidInputError, match=message):
            score_missing(fit, candidates)


def delays(recording):
    """Of transponders, in the ranges of all sensors; and azimuths of one sensor."""
    own = [known_terms(sensor) for sensor in recording.sensors]
    return [{k: terms["range"] for k, terms in enumerate(own)}, {1: own[1]["azimuth"]}]


def with_delays(seed, sd):
    """A recording of targets with delays of their own; everything else may go wrong too."""
    recording, setup, truth = draw(seed, reports=1500, wrong_share=0.2, outlier_share=0.05)
    model, _ = model_of(recording, setup, wrong_share=0.05)
    own = sd * np.random.default_rng(seed).standard_normal(truth.target.max() + 1)
    values = model.reports.values.copy()
    values[:, 0] += own[truth.target]
    model = replace(model, reports=replace(model.reports, values=values), guess=None)
    return score_spread(fit_tracks(model), delays(recording))


def test_errors_of_targets_of_their_own_are_seen():
    scores = with_delays(21, 60.0)
    assert scores.z[0] > 10.0
    assert 30.0 < scores.sd[0] < 90.0
    assert scores.z[0] > 3.0 * scores.z[1]


def test_where_targets_have_none_the_scores_of_spreads_are_standard_normal():
    z = np.array([with_delays(seed, 0.0).z for seed in range(20)])
    assert np.abs(z).max() < 4.0
    # means of twenty, a false alarm in a thousand; squares are skew, so with some room
    assert np.abs(z.mean(axis=0)).max() < 3.5 / np.sqrt(20.0)
    assert (z.std(axis=0) > 0.5).all()
    assert (z.std(axis=0) < 1.7).all()
