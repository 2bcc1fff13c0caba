"""The whole chain on simulated traffic."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats
from sklearn.metrics import roc_auc_score

from probreg.diagnostics import Coverage
from probreg.errors import InvalidInputError
from probreg.registration import LAWS, STEPS, compare_terms, register
from probreg.scenarios.traffic import TrafficScene, radars, simulate
from probreg.sensors.geometry import wrap_angle

DIRTY = {"wrong_share": 0.2, "outlier_share": 0.05}


def truth_of(found, truth):
    return np.array([truth.bias.get(name, 0.0) for name in found.names])


@pytest.fixture(scope="module")
def registered():
    scene = TrafficScene(3_000, **DIRTY)
    recording, setup, truth = simulate(scene, np.random.default_rng(11))
    setup = dataclasses.replace(setup, limits={"radar1.range": 5.0, "radar2.azimuth": 0.5})
    return register(recording, setup, rng=np.random.default_rng(12)), truth


def test_biases_are_found_in_dirty_reports(registered):
    found, truth = registered
    # 6 biases at 4.5 posterior standard deviations: false alarm about 1e-4 with some tail
    assert (np.abs(found.mean - truth_of(found, truth)) < 4.5 * found.sd).all()
    assert (found.sd < 0.2 * found.problem.prior_sd).all()
    table = found.table()
    assert list(table.index) == list(found.names)
    assert (table["90% low"] < table["50% low"]).all()
    assert np.allclose(np.diag(found.correlation), 1.0)


def test_held_out_targets_are_corrected(registered):
    found, _ = registered
    before, after = found.held_out.medians_m
    assert after < 0.4 * before
    assert found.held_out.after_log_score > found.held_out.before_log_score + 1.0
    assert 0 < found.held_out.targets < len(found.problem.owner)


def test_single_wrong_reports_are_marked(registered):
    found, truth = registered
    # `truth` counts reports as the recording does, and every report is of a track here
    assert (found.problem.rows == np.arange(len(found.recording))).all()
    bad = truth.outlier | truth.wrong
    # ten times the noise is at times no more than the usual: not every outlier can be seen
    assert roc_auc_score(bad, found.bad) > 0.99
    assert (found.bad[~bad] > 0.5).mean() < 0.005
    suspects = found.suspects()
    assert set(suspects["report"]) == set(np.flatnonzero(found.bad > 0.5))
    assert (np.diff(suspects["probability"]) <= 0.0).all()
    # a report that is given to another target is given to the one it is of
    moved = found.fit.target != found.recording.target
    assert moved.sum() > 0.4 * truth.wrong.sum()
    assert (found.fit.target[moved] == truth.target[moved]).mean() > 0.99


def test_laws_verdicts_notes_and_times(registered):
    found, _ = registered
    assert {law.name for law in found.laws} == {choice.name for choice in LAWS}
    assert found.laws[-1].name == "Gaussian"
    assert found.law == "Contaminated"
    by_name = {verdict.name: verdict for verdict in found.verdicts}
    assert by_name["radar2.azimuth"].text == "within"
    size = np.abs(found.bias_draws[:, found.names.index("radar1.range")])
    assert by_name["radar1.range"].probability == (size > 5.0).mean()
    assert any("fit another target than the one" in note for note in found.notes)
    assert set(found.seconds) == set(STEPS)


def test_correcting_is_undone_by_restoring(registered):
    found, _ = registered
    back = found.restore(found.correct())
    np.testing.assert_allclose(back.values, found.recording.values, rtol=1e-14)


def test_residuals_are_of_the_reports_less_the_true_paths(registered):
    """The tracks are near the truth, so residuals are near the errors that were drawn."""
    found, truth = registered
    good = ~(truth.outlier | truth.wrong) & (found.bad < 0.5)
    bias = dict(zip(found.names, truth_of(found, truth), strict=True))
    for k, sensor in enumerate(found.recording.sensors):
        rows = np.flatnonzero(good & (found.recording.sensor == k))
        error = found.recording.values[rows, :2] - sensor.to_report(truth.positions[rows, :2])
        error[:, 1] = wrap_angle(error[:, 1])
        left = found.residuals.before[rows, :2]
        # what is left of the paths' own errors, in the sd of all
        away = (left - error) / found.residuals.sd[rows, :2]
        assert np.median(np.abs(away)) < 0.6
        own = [bias[f"{sensor.name}.{name}"] for name in sensor.bias_names]
        shift = found.residuals.before[rows, :2] - found.residuals.after[rows, :2]
        assert (np.abs(shift - own) < 4.5 * found.sd[2 * k : 2 * k + 2] + 1e-9).all()
        z = found.residuals.after[rows, :2] / found.residuals.sd[rows, :2]
        assert (np.abs(z.std(axis=0) - 1.0) < 0.12).all()


def test_tracks_are_where_the_targets_were(registered):
    found, truth = registered
    table = found.tracks()
    assert (np.diff(table["track"]) >= 0).all()
    report = table["report"].to_numpy()
    flown = found.fit.target[report] == truth.target[report]
    own = flown & table["used"].to_numpy()
    away = table[["x", "y"]].to_numpy() - truth.positions[report, :2]
    C = np.empty((len(table), 2, 2))
    C[:, 0, 0], C[:, 1, 1] = table["cov_xx"], table["cov_yy"]
    C[:, 0, 1] = C[:, 1, 0] = table["cov_xy"]
    d2 = np.einsum("ni,nij,nj->n", away, np.linalg.inv(C), away)
    inside = (d2 < stats.chi2(2).ppf(0.9))[own]
    # states of one track hang together: of about 40 tracks the share has an sd near .015
    assert 0.85 < inside.mean() < 0.95


def test_equal_seeds_give_equal_results():
    scene = TrafficScene(400, **DIRTY)
    recording, setup, _ = simulate(scene, np.random.default_rng(1))
    one, two = (register(recording, setup, rng=np.random.default_rng(2)) for _ in range(2))
    np.testing.assert_array_equal(one.draws.theta, two.draws.theta)


def test_clock_and_gain_are_found_and_compared():
    extra = {"radar1.range": 40.0, "radar2.time": 0.8, "radar3.range_gain": 2e-3}
    recording, setup, truth = simulate(TrafficScene(4_000, biases=extra), np.random.default_rng(4))
    found = register(recording, setup, rng=np.random.default_rng(5))
    assert {"radar2.time", "radar3.range_gain"} <= set(found.names)
    assert (np.abs(found.mean - truth_of(found, truth)) < 4.5 * found.sd).all()
    offsets = {s.name: ("range", "azimuth") for s in setup.sensors}
    every = {name: (*terms, "azimuth_sine") for name, terms in setup.biases.items()}
    ranked = compare_terms(
        found.recording,
        setup,
        {"offsets": offsets, "asked for": setup.biases, "and eccentricity": every},
        rng=np.random.default_rng(6),
    )
    assert ranked[-1].name == "offsets"
    assert ranked[-1].behind > 5.0 * ranked[-1].standard_error
    # a term that is not there costs next to nothing and gains nothing
    assert abs(ranked[1].behind) < 20.0


def test_bad_requests():
    recording, setup, _ = simulate(TrafficScene(300), np.random.default_rng(1))
    rng = np.random.default_rng(2)
    with pytest.raises(InvalidInputError, match="holdout 1.5 must be in"):
        register(recording, setup, rng=rng, holdout=1.5)
    with pytest.raises(InvalidInputError, match="laws must be different, one at least"):
        register(recording, setup, rng=rng, laws=[])
    with pytest.raises(InvalidInputError, match="two bias models"):
        compare_terms(recording, setup, {"one": setup.biases}, rng=rng)
    other = dataclasses.replace(setup, sensors=radars(2), biases={"radar1": ("range",)})
    with pytest.raises(InvalidInputError, match="must be the same, in one order"):
        register(recording, other, rng=rng)


@pytest.mark.slow
@pytest.mark.parametrize("reports", [500, 50_000])
def test_intervals_cover(reports):
    # 200 recordings of 6 biases; pooled coverage within exact binomial limits, false alarm 5 %
    held, count = 0, 0
    for seed in range(200):
        rng = np.random.default_rng([77, reports, seed])
        recording, setup, truth = simulate(TrafficScene(reports, **DIRTY), rng)
        found = register(recording, setup, rng=rng)
        low, high = found.interval(0.9).T
        inside = (low <= truth_of(found, truth)) & (truth_of(found, truth) <= high)
        held, count = held + int(inside.sum()), count + inside.size
    assert Coverage(held, count, 0.9).honest(0.05)


@pytest.mark.slow
def test_a_million_reports():
    import resource

    recording, setup, truth = simulate(TrafficScene(1_000_000, **DIRTY), np.random.default_rng(1))
    found = register(recording, setup, rng=np.random.default_rng(2))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 4e6  # kilobytes
    assert (np.abs(found.mean - truth_of(found, truth)) < 4.5 * found.sd).all()
